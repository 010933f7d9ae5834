/** The server of this page: its addresses, token and list of models. */

import { HttpError } from "./http_error";

export interface ListedModel {
  name: string;
  build_id: string;
  triangles: number;
  bytes: number;
  has_textures: boolean;
}

export interface ModelList {
  models: ListedModel[];
  /** Port of the native protocol; null if other machines cannot reach it. */
  native?: { port: number; tls: boolean } | null;
}

const kTokenKey = "lodestream-token";
/** A token in the page's path: `/t/TOKEN/`. The WebSocket's path has no token: a message carries it. */
const kTokenPath = /t\/([^/]+)\/$/;

/** Returns the token for this server, or "". */
export function token(): string {
  try {
    const kept = sessionStorage.getItem(kTokenKey);
    if (kept) return kept;
  } catch {
    // Storage is switched off.
  }
  const in_path = kTokenPath.exec(pathOf());
  return in_path ? decodeURIComponent(in_path[1] ?? "") : "";
}

/** Keeps a token until the tab closes. */
export function keepToken(value: string): void {
  try {
    sessionStorage.setItem(kTokenKey, value);
  } catch {
    // Without storage, the token is lost when the page is reloaded, unless the path contains it.
  }
}

export function socketUrl(): string {
  const url = new URL(document.baseURI);
  url.pathname = pathOf().replace(kTokenPath, "") + "ws";
  url.protocol = url.protocol === "https:" ? "wss:" : "ws:";
  url.search = url.hash = "";
  return url.href;
}

/** @throws HttpError, or TypeError if the server is not reachable. */
export async function fetchModels(): Promise<ModelList> {
  const headers: Record<string, string> = {};
  const bearer = token();
  if (bearer) headers["Authorization"] = `Bearer ${bearer}`;
  const response = await fetch(new URL("models.json", document.baseURI), { headers });
  if (!response.ok) throw new HttpError(response.status);
  return (await response.json()) as ModelList;
}

/** Returns the link that opens a model in the desktop client, or null if the server is unreachable. */
export function nativeLink(list: ModelList, model: string): string | null {
  if (!list.native) return null;
  const { port, tls } = list.native;
  return `${tls ? "lodes" : "lode"}://${location.hostname}:${port}/${encodeURIComponent(model)}`;
}

/** Returns the path of the page's folder, with a slash at its end. */
function pathOf(): string {
  return new URL(".", document.baseURI).pathname;
}
