import { kShowModes, type CameraView, type ShowMode, type Vec3 } from "./contract";

/** State of the page that its address carries in the fragment. */
export interface PageLink {
  model: string | null;
  camera: CameraView | null;
  threshold_px: number | null;
  show: ShowMode | null;
  token: string | null;
}

const kMostThresholdPx = 64;
const kDigits = 12; // significant digits of a coordinate: micrometres in a map projection

/** Parses a fragment. Ignores invalid values, because a mail program may have cut the link. */
export function parseLink(fragment: string): PageLink {
  const fields = new URLSearchParams(fragment.replace(/^#/, ""));
  const eye = vectorOf(fields.get("eye"));
  const target = vectorOf(fields.get("target"));
  const up = vectorOf(fields.get("up"));
  const fov = Number(fields.get("fov") ?? 45);
  const camera = eye && target && up && fov > 0 && fov < 180 ? { eye, target, up, fov_y_deg: fov } : null;
  const px = Number(fields.get("px") ?? NaN);
  const show = fields.get("show");
  return {
    model: fields.get("model") || null,
    camera,
    threshold_px: px > 0 && px <= kMostThresholdPx ? px : null,
    show: kShowModes.find((mode) => mode === show) ?? null,
    token: fields.get("token"),
  };
}

/** Returns the fragment of a model's page, with "#". */
export function modelLink(model: string): string {
  return `#model=${encodeURIComponent(model)}`;
}

/** Returns the fragment that reproduces the current picture. It never contains the token. */
export function formatLink(model: string, camera: CameraView, threshold_px: number, show: ShowMode): string {
  const fields = [
    modelLink(model),
    `eye=${formatVector(camera.eye)}`,
    `target=${formatVector(camera.target)}`,
    `up=${formatVector(camera.up)}`,
    `fov=${formatNumber(camera.fov_y_deg)}`,
    `px=${formatNumber(threshold_px)}`,
    `show=${show}`,
  ];
  return fields.join("&");
}

/** Returns a fragment without the token, so that it does not stay in the address bar or the history. */
export function withoutToken(fragment: string): string {
  const fields = new URLSearchParams(fragment.replace(/^#/, ""));
  fields.delete("token");
  const rest = [...fields].map(([name, value]) => `${name}=${encodeURIComponent(value).replace(/%2C/g, ",")}`);
  return rest.length > 0 ? `#${rest.join("&")}` : "";
}

function vectorOf(text: string | null): Vec3 | null {
  const numbers = (text ?? "").split(",").map((part) => (part.trim() === "" ? NaN : Number(part)));
  const [x, y, z] = numbers;
  if (numbers.length !== 3 || !numbers.every(Number.isFinite)) return null;
  return x === undefined || y === undefined || z === undefined ? null : [x, y, z];
}

function formatVector(vector: Vec3): string {
  return vector.map(formatNumber).join(",");
}

function formatNumber(value: number): string {
  return String(Number(value.toPrecision(kDigits)));
}
