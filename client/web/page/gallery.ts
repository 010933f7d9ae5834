import { element, find } from "./dom";
import { explainListing, report } from "./errors";
import { startHost } from "./host";
import { modelLink, parseLink } from "./link";
import { HttpError } from "./http_error";
import { fetchModels, keepToken, type ListedModel } from "./server";
import { forgetPictures, Thumbnails } from "./thumbnails";
import { formatBytes, formatTriangles } from "./words";

/** Smallest number of models for which the gallery shows a search box. */
const kManyModels = 9;

/** The page of all models of the server. */
export class Gallery {
  private readonly root = find("#gallery");
  private readonly cards = find("#cards");
  private readonly message = find("#gallery_message");
  private readonly search = find<HTMLInputElement>("#search");
  private thumbnails: Thumbnails | null = null;
  private observer: IntersectionObserver | null = null;

  /** @param entered  called when the server has accepted a token, to show the page that the address names. */
  constructor(private readonly entered: () => void) {
    this.search.addEventListener("input", () => this.filter());
    find<HTMLFormElement>("#token_form").addEventListener("submit", (event) => {
      event.preventDefault();
      keepToken(find<HTMLInputElement>("#token").value.trim());
      void this.load(true);
    });
    find("#retry").addEventListener("click", () => void this.load());
  }

  show(): void {
    document.title = "Models – Lodestream";
    this.root.hidden = false;
    void this.load();
  }

  hide(): void {
    this.root.hidden = true;
    this.observer?.disconnect();
    this.thumbnails?.stop();
    this.thumbnails = null;
    this.cards.replaceChildren();
  }

  private async load(has_new_token = false): Promise<void> {
    this.say("Loading the list of models…");
    try {
      const { models } = await fetchModels();
      if (this.root.hidden) return;
      if (has_new_token && parseLink(location.hash).model !== null) {
        this.entered();
        return;
      }
      this.list(models);
      void forgetPictures(models);
    } catch (error) {
      report(error);
      if (this.root.hidden) return;
      const wants_token = error instanceof HttpError && error.wantsToken;
      const refusal = has_new_token ? "The server does not accept this token." : "";
      this.say(wants_token ? refusal : explainListing(error), !wants_token);
      find("#token_form").hidden = !wants_token;
    }
  }

  private list(models: ListedModel[]): void {
    find("#token_form").hidden = true;
    this.say(models.length === 0 ? "This server has no models yet. They appear here when it serves some." : "");
    this.search.hidden = models.length < kManyModels;
    this.observer?.disconnect();
    this.thumbnails?.stop();
    const thumbnails = (this.thumbnails = new Thumbnails(startHost));
    const pictures = new Map<Element, () => void>();
    this.observer = new IntersectionObserver(
      (entries, observer) => {
        for (const { isIntersecting, target } of entries) {
          if (!isIntersecting) continue;
          observer.unobserve(target);
          pictures.get(target)?.();
        }
      },
      { rootMargin: "100px" },
    );
    this.cards.replaceChildren(
      ...models.map((model) => {
        const { card, frame } = makeCard(model);
        pictures.set(frame, () => void fill(frame, thumbnails.request(model)));
        this.observer?.observe(frame);
        return card;
      }),
    );
    this.filter();
  }

  private filter(): void {
    const wanted = this.search.hidden ? "" : this.search.value.trim().toLowerCase();
    let found = 0;
    for (const card of this.cards.children) {
      const matches = (card.textContent ?? "").toLowerCase().includes(wanted);
      (card as HTMLElement).hidden = !matches;
      found += Number(matches);
    }
    if (wanted) this.say(found === 0 ? "No model has this in its name." : "");
  }

  private say(text: string, can_retry = false): void {
    this.message.textContent = text;
    this.message.hidden = text === "";
    find("#retry").hidden = !can_retry;
  }
}

function makeCard(model: ListedModel): { card: HTMLElement; frame: HTMLElement } {
  const frame = element("span", { class: "picture" });
  const details = [formatTriangles(model.triangles), formatBytes(model.bytes)];
  if (model.has_textures) details.push("textures");
  const link = element("a", { class: "card", href: modelLink(model.name) }, [
    frame,
    element("span", { class: "name" }, [model.name]),
    element("span", { class: "details" }, [details.map((detail) => detail.replace(/ /g, "\u00a0")).join(" · ")]),
  ]);
  return { card: element("li", {}, [link]), frame };
}

/** Waits for a picture and puts it into its frame. */
async function fill(frame: HTMLElement, picture: Promise<string | null>): Promise<void> {
  frame.classList.add("loading");
  const url = await picture;
  frame.classList.remove("loading");
  if (!url) {
    frame.classList.add("missing");
    return;
  }
  frame.append(element("img", { src: url, alt: "", width: "320", height: "200" }));
}
