import { html, nothing, render, type TemplateResult } from "lit";
import { repeat } from "lit/directives/repeat.js";
import { startTexts } from "../../texts/start.ts";
import { brand, languageChoice, problemCard, themeButton } from "../shell/chrome.ts";
import { formatBytes } from "../shell/format.ts";
import { type Problem, problemOf } from "../shell/problems.ts";
import { onTheme } from "../shell/theme.ts";
import {
  ApiError,
  fetchLists,
  fetchScenes,
  fetchVolumes,
  type SceneEntry,
  type SceneList,
  type VolumeEntry,
  type VolumeList,
  withBackoff,
} from "../shell/volumes_api.ts";
import { sceneCard, skeleton, volumeCard } from "./cards.ts";
import { keepPlace, keptPlace } from "./list_place.ts";
import { Previews } from "./previews.ts";

/** A search begins when its text has not changed for this time (ms). */
const typingPause = 200;

/** The lists of scenes and volumes on the server, and a form to open a store by its address. */
export class Catalog {
  readonly #root: HTMLElement;
  /** The volumes that are shown, with the total of those that match #shownQuery. */
  #list: VolumeList | null = null;
  /** The scenes that are shown, with the total of those that match #shownQuery. */
  #scenes: SceneList | null = null;
  #problem: Problem | null = null;
  #query = "";
  #shownQuery = "";
  /** The query that is being loaded, or was loaded last. */
  #loadedQuery = "";
  /** The first list without a query, for the page's header. */
  #all: VolumeList | null = null;
  #allScenes: SceneList | null = null;
  #loading = new AbortController();
  #isLoading = false;
  #searchTimer = 0;
  readonly #previews = new Previews(() => this.#render());
  /** Content ids of volumes and scenes whose picture could not be loaded. */
  readonly #withoutPicture = new Set<string>();
  /** Observes which cards are visible. This browser draws a picture of those without one. */
  readonly #cardObserver = new IntersectionObserver((entries) => {
    for (const { isIntersecting, target } of entries) {
      const { name, scene } = (target as HTMLElement).dataset;
      const entry =
        this.#list?.volumes.find((each) => each.name === name) ??
        this.#scenes?.scenes.find((each) => each.name === scene);
      if (isIntersecting && entry && !this.#servedPicture(entry)) this.#draw(entry);
    }
  });

  readonly #device: HTMLElement;

  /** `device`: the part of the page for files on this device. */
  constructor(root: HTMLElement, device: HTMLElement) {
    this.#root = root;
    this.#device = device;
    document.title = "Isosplat";
    onTheme(() => this.#render());
    window.addEventListener("pagehide", () => this.#keepPlace());
    void this.#begin();
  }

  /** Loads the list, and returns to the place where the visitor left it. */
  async #begin(): Promise<void> {
    const place = keptPlace();
    await this.#load();
    if (!place) return;
    if (place.query !== "") {
      this.#query = place.query;
      await this.#load();
    }
    await this.#loadUntil("volumes", place.volumes);
    await this.#loadUntil("scenes", place.scenes);
    if (window.scrollY === 0) window.scrollTo({ top: place.top, behavior: "instant" });
  }

  /** Loads more of a list until it shows this many entries, or has no more. */
  async #loadUntil(list: "volumes" | "scenes", count: number): Promise<void> {
    let before = -1;
    let shown = this.#shown[list];
    while (shown > before && shown < count) {
      await this.#load(list);
      before = shown;
      shown = this.#shown[list];
    }
  }

  /** The number of entries that are shown. */
  get #shown() {
    return {
      volumes: this.#list?.volumes.length ?? 0,
      scenes: this.#scenes?.scenes.length ?? 0,
    };
  }

  #keepPlace(): void {
    keepPlace({ query: this.#shownQuery, ...this.#shown, top: window.scrollY });
  }

  /** The URL of the picture of a volume or a scene on the server or site. */
  #servedPicture({ contentId, thumbnail }: VolumeEntry | SceneEntry): string | null {
    if (!contentId || !thumbnail || this.#withoutPicture.has(contentId)) return null;
    return thumbnail.replace(/^\/+/, ""); // relative, since the page may be below a path that the server does not know
  }

  /** Draws a picture in this browser. */
  #draw(entry: VolumeEntry | SceneEntry): void {
    const { name, contentId } = entry;
    const { layers } = entry as SceneEntry;
    if (contentId) this.#previews.request({ name, contentId, ...(layers && { layers }) });
  }

  #drawInstead(entry: VolumeEntry | SceneEntry): void {
    if (!entry.contentId) return;
    this.#withoutPicture.add(entry.contentId);
    this.#draw(entry);
    this.#render();
  }

  #search(text: string): void {
    this.#query = text.trim();
    clearTimeout(this.#searchTimer);
    this.#searchTimer = window.setTimeout(() => {
      if (this.#query !== this.#loadedQuery) void this.#load();
    }, typingPause);
  }

  /** Loads the lists for the query; with `more`, the next entries of one list. */
  async #load(more?: "volumes" | "scenes"): Promise<void> {
    this.#loading.abort();
    this.#loading = new AbortController();
    const { signal } = this.#loading;
    const query = more ? this.#shownQuery : this.#query;
    this.#loadedQuery = query;
    this.#problem = null;
    this.#isLoading = true;
    this.#render();
    try {
      const { volumes, scenes } = await withBackoff(
        () => this.#fetch(query, more, signal),
        signal,
        (error) => {
          this.#problem = listProblem(error);
          this.#render();
        },
      );
      this.#list = volumes;
      this.#scenes = scenes;
      this.#shownQuery = query;
      if (query === "") {
        this.#all = volumes;
        this.#allScenes = scenes;
      }
      this.#problem = null;
    } catch (error) {
      if (signal.aborted) return;
      this.#problem = listProblem(error);
      if (error instanceof ApiError && error.denied) {
        this.#problem = {
          ...this.#problem,
          title: startTexts.needsToken,
          text: startTexts.needsTokenText,
        };
      } else if (error instanceof ApiError && !error.retry) {
        this.#problem = {
          ...this.#problem,
          title: startTexts.noList,
          text: startTexts.noListText,
        };
      }
    }
    this.#isLoading = false;
    this.#render();
  }

  async #fetch(query: string, more: "volumes" | "scenes" | undefined, signal: AbortSignal) {
    const [volumes, scenes] = [this.#list, this.#scenes];
    if (!more || !volumes || !scenes) return fetchLists({ query }, signal);
    if (more === "volumes") {
      const before = volumes.volumes;
      const next = await fetchVolumes({ query, offset: before.length }, signal);
      return { volumes: { ...next, volumes: joined(before, next.volumes) }, scenes };
    }
    const before = scenes.scenes;
    const next = await fetchScenes({ query, offset: before.length }, signal);
    return { volumes, scenes: { ...next, scenes: joined(before, next.scenes) } };
  }

  #render(): void {
    const list = this.#list;
    const scenes = this.#scenes;
    const hasScenes = (this.#allScenes?.total ?? 0) > 0;
    const total = (list?.total ?? 0) + (scenes?.total ?? 0);
    render(
      html`<div class="catalog">
        <header class="bar">${brand()}<span class="bar-space"></span>${languageChoice()}${themeButton()}</header>
        <main class="catalog-main">
          <div class="catalog-head">
            <div>
              <h1>${hasScenes ? startTexts.scenesAndVolumes : startTexts.volumes}</h1>
              <p class="quiet">
                ${this.#all ? summary(this.#all, this.#allScenes) : startTexts.lead}
              </p>
            </div>
            ${
              this.#all && this.#all.total + (this.#allScenes?.total ?? 0) > 6
                ? html`<wa-input
                    class="catalog-filter no-label"
                    size="s"
                    type="search"
                    placeholder=${startTexts.search}
                    label=${startTexts.searchLabel}
                    .value=${this.#query}
                    @input=${(event: Event) => this.#search((event.target as HTMLInputElement).value)}
                  ></wa-input>`
                : nothing
            }
          </div>
          ${this.#device}
          ${this.#problem ? problemCard(this.#problem, { retry: () => void this.#load() }) : nothing}
          ${
            this.#all?.keptAt
              ? html`<p class="list-note" role="status">
                  ${startTexts.keptList(this.#all.keptAt.toLocaleString(document.documentElement.lang))}
                </p>`
              : nothing
          }
          ${list || this.#problem ? nothing : skeleton()}
          ${
            this.#all?.total === 0 && !hasScenes
              ? html`<p class="empty">
                  ${startTexts.noVolumes(html`<code>isosplat build VOLUME</code>`)}
                </p>`
              : nothing
          }
          ${
            this.#shownQuery !== "" && list
              ? html`<p class=${total === 0 ? "empty" : "list-note"} role="status">
                  ${
                    total === 0
                      ? startTexts.noMatch(this.#shownQuery)
                      : startTexts.matches(counts(list, scenes), this.#shownQuery)
                  }
                </p>`
              : nothing
          }
          ${
            scenes && scenes.total > 0
              ? html`<section class="scene-list">
                  <h2>${startTexts.scenes}</h2>
                  <ul class="cards">
                    ${repeat(
                      scenes.scenes,
                      ({ name }) => name,
                      (scene) =>
                        html`<li>${sceneCard(scene, this.#servedPicture(scene), () => this.#drawInstead(scene))}</li>`,
                    )}
                  </ul>
                  ${this.#more("scenes", scenes.scenes.length, scenes.total)}
                </section>`
              : nothing
          }
          ${hasScenes && list && list.total > 0 ? html`<h2 class="volumes-head">${startTexts.volumes}</h2>` : nothing}
          <ul class="cards">
            ${repeat(
              list?.volumes ?? [],
              ({ name }) => name,
              (volume) =>
                html`<li>${volumeCard(volume, this.#servedPicture(volume), () => this.#drawInstead(volume))}</li>`,
            )}
          </ul>
          ${this.#more("volumes", list?.volumes.length ?? 0, list?.total ?? 0)}
          ${openByAddress()}
        </main>
      </div>`,
      this.#root,
    );
    for (const element of this.#root.querySelectorAll("a.card[data-name], a.card[data-scene]"))
      this.#cardObserver.observe(element);
  }

  /** The number of entries of a list that are not shown, with a button for more. */
  #more(list: "volumes" | "scenes", shown: number, total: number): TemplateResult | typeof nothing {
    if (shown >= total) return nothing;
    return html`<p class="more-volumes">
      <wa-button
        size="s"
        appearance="outlined"
        ?loading=${this.#isLoading}
        @click=${() => void this.#load(list)}
        >${startTexts.showMore}</wa-button
      >
      <span class="quiet">${startTexts.notShown(total - shown, total)}</span>
    </p>`;
  }
}

/** Removes duplicates: if an entry was added to the list in the meantime, others have moved to the next page. */
function joined<T extends { name: string }>(before: readonly T[], next: readonly T[]): T[] {
  const names = new Set(before.map(({ name }) => name));
  return [...before, ...next.filter(({ name }) => !names.has(name))];
}

function listProblem(error: unknown): Problem {
  return { ...problemOf(error, startTexts.theList), offers: ["again"] };
}

function summary({ total, fileBytes }: VolumeList, scenes: SceneList | null): string {
  const volumes =
    fileBytes > 0 ? startTexts.onServer(total, formatBytes(fileBytes)) : startTexts.count(total);
  return scenes && scenes.total > 0
    ? `${startTexts.sceneCount(scenes.total)}, ${volumes}`
    : volumes;
}

/** "2 scenes, 3 volumes", without a kind that has none. */
function counts(volumes: VolumeList, scenes: SceneList | null): string {
  return [
    scenes && scenes.total > 0 ? startTexts.sceneCount(scenes.total) : "",
    volumes.total > 0 ? startTexts.count(volumes.total) : "",
  ]
    .filter(Boolean)
    .join(", ");
}

function openByAddress(): TemplateResult {
  const open = (event: Event) => {
    event.preventDefault();
    const input = (event.currentTarget as HTMLFormElement).querySelector("wa-input");
    const address = (input as unknown as HTMLInputElement | null)?.value.trim();
    if (address) location.search = `?src=${encodeURIComponent(address)}`;
  };
  return html`<section class="by-address">
    <h2>${startTexts.elsewhere}</h2>
    <p class="quiet">${startTexts.elsewhereText}</p>
    <form @submit=${open}>
      <wa-input
        class="no-label"
        size="s"
        type="url"
        name="src"
        placeholder="https://example.org/head.isosplat"
        label=${startTexts.address}
      ></wa-input>
      <wa-button type="submit" size="s" appearance="filled">${startTexts.open}</wa-button>
    </form>
  </section>`;
}
