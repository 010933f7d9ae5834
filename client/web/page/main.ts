import { find } from "./dom";
import { errors, watchErrors } from "./errors";
import { Gallery } from "./gallery";
import { parseLink, withoutToken } from "./link";
import { keepToken } from "./server";
import { Viewer, type ViewerState } from "./viewer";

/** The page: without a fragment the gallery of models, with a fragment the viewer of one model. */

declare global {
  interface Window {
    /** For tests. */
    lodestream: {
      state(): (ViewerState & { errors: string[] }) | { errors: string[] };
      viewer(): Viewer | null;
    };
  }
}

const gallery = new Gallery(() => route());
let viewer: Viewer | null = null;

/** Shows the gallery or the model that the address names. */
function route(): void {
  const link = parseLink(location.hash);
  if (link.token) {
    keepToken(link.token);
    history.replaceState(null, "", location.pathname + location.search + withoutToken(location.hash));
  }
  if (link.model !== null && link.model === viewer?.modelName) {
    viewer.follow(link);
    return;
  }
  viewer?.close();
  viewer = null;
  gallery.hide();
  if (link.model === null) gallery.show();
  else viewer = new Viewer(link.model, link, askForToken);
}

/** Shows the gallery, which asks for a token, and then the page that the address names. */
function askForToken(): void {
  viewer?.close();
  viewer = null;
  gallery.show();
}

watchErrors();
document.body.classList.toggle("embed", new URLSearchParams(location.search).has("embed"));
for (const button of document.querySelectorAll("dialog [data-close]"))
  button.addEventListener("click", () => button.closest("dialog")?.close());
find<HTMLDialogElement>("#help").addEventListener("click", (event) => {
  if (event.target === event.currentTarget) (event.currentTarget as HTMLDialogElement).close();
});
window.lodestream = {
  state: () => ({ ...viewer?.state(), errors: [...errors] }),
  viewer: () => viewer,
};
addEventListener("hashchange", route);
route();
