/** Keeps errors of the page for tests, and explains them to users. */

import { HttpError } from "./http_error";

const kMostErrors = 50;
export const errors: string[] = [];

export function report(error: unknown): void {
  if (errors.length < kMostErrors) errors.push(error instanceof Error ? error.message : String(error));
}

export function watchErrors(): void {
  addEventListener("error", (event) => report(event.error ?? event.message));
  addEventListener("unhandledrejection", (event) => report(event.reason));
}

/** Says why the list of models is not shown, and what to do. */
export function explainListing(error: unknown): string {
  if (error instanceof HttpError && error.status === 429)
    return "The server has too many visitors. Try again in a minute.";
  if (error instanceof HttpError && error.status === 503)
    return "The server is busy. Try again in a minute.";
  if (error instanceof HttpError)
    return `The server answers with an error (HTTP ${error.status}). Try again later, or tell its operator.`;
  if (error instanceof TypeError) return "The server does not answer. Check your connection, then try again.";
  return "The list of models cannot be read. Reload the page; if that does not help, tell the server's operator.";
}

/** Says why the viewer cannot start, and what to do. */
export function explainStart(error: unknown): string {
  const text = error instanceof Error ? error.message : String(error);
  if (typeof WebAssembly === "undefined" || error instanceof WebAssembly.CompileError)
    return "This browser cannot run the viewer, because its WebAssembly is switched off or too old. Update it, or use another browser.";
  if (/webgl/i.test(text))
    return "This browser cannot draw 3D pictures, because WebGL 2 is missing or switched off. Switch on hardware acceleration in its settings, or use another browser.";
  if (error instanceof RangeError || /memory/i.test(text))
    return "This page has run out of memory. Close other tabs, choose a smaller memory limit under Detail, and reload.";
  if (error instanceof TypeError || error instanceof HttpError)
    return "A part of the viewer cannot be loaded. Check your connection, then reload the page.";
  return "The viewer cannot start. Reload the page; if that does not help, use another browser.";
}
