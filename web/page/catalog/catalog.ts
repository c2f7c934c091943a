import { html, nothing, render, type TemplateResult } from "lit";
import { repeat } from "lit/directives/repeat.js";
import { pageTexts } from "../../texts/page.ts";
import { startTexts } from "../../texts/start.ts";
import { brand, languageChoice, problemCard, themeButton } from "../shell/chrome.ts";
import { formatBytes, formatCount, formatDims, formatType, formatValue } from "../shell/format.ts";
import { icon } from "../shell/icons.ts";
import { type Problem, problemOf } from "../shell/problems.ts";
import { onTheme } from "../shell/theme.ts";
import { thumbnail } from "../shell/thumbnails.ts";
import {
  ApiError,
  fetchVolumes,
  type VolumeEntry,
  type VolumeList,
  withBackoff,
} from "../shell/volumes_api.ts";
import { Previews } from "./previews.ts";

/** A search begins when its text has not changed for this time (ms). */
const typingPause = 200;

/** The list of volumes on the server, and a form to open a store by its address. */
export class Catalog {
  readonly #root: HTMLElement;
  /** The volumes that are shown, with the total of those that match #shownQuery. */
  #list: VolumeList | null = null;
  #problem: Problem | null = null;
  #query = "";
  #shownQuery = "";
  /** The query that is being loaded, or was loaded last. */
  #loadedQuery = "";
  /** The first list without a query, for the page's header. */
  #all: VolumeList | null = null;
  #loading = new AbortController();
  #isLoading = false;
  #searchTimer = 0;
  readonly #previews = new Previews(() => this.#render());
  /** Content ids of volumes whose picture could not be loaded. */
  readonly #withoutPicture = new Set<string>();
  /** Observes which cards are visible. This browser draws a picture for volumes without one. */
  readonly #cardObserver = new IntersectionObserver((entries) => {
    for (const { isIntersecting, target } of entries) {
      const volume = this.#list?.volumes.find(
        ({ name }) => name === (target as HTMLElement).dataset.name,
      );
      if (isIntersecting && volume?.contentId && !this.#servedPicture(volume)) {
        this.#previews.request({ name: volume.name, contentId: volume.contentId });
      }
    }
  });

  readonly #device: HTMLElement;

  /** `device`: the part of the page for files on this device. */
  constructor(root: HTMLElement, device: HTMLElement) {
    this.#root = root;
    this.#device = device;
    document.title = "Isosplat";
    onTheme(() => this.#render());
    void this.#load();
  }

  /** The URL of a volume's picture on the server or site. */
  #servedPicture({ contentId, thumbnail }: VolumeEntry): string | null {
    if (!contentId || !thumbnail || this.#withoutPicture.has(contentId)) return null;
    return thumbnail.replace(/^\/+/, ""); // relative, since the page may be below a path that the server does not know
  }

  #drawInstead({ name, contentId }: VolumeEntry): void {
    if (!contentId) return;
    this.#withoutPicture.add(contentId);
    this.#previews.request({ name, contentId });
    this.#render();
  }

  #search(text: string): void {
    this.#query = text.trim();
    clearTimeout(this.#searchTimer);
    this.#searchTimer = window.setTimeout(() => {
      if (this.#query !== this.#loadedQuery) void this.#load();
    }, typingPause);
  }

  /** Loads the list for the query; with `isMore`, its next volumes. */
  async #load({ isMore = false } = {}): Promise<void> {
    this.#loading.abort();
    this.#loading = new AbortController();
    const { signal } = this.#loading;
    const query = isMore ? this.#shownQuery : this.#query;
    this.#loadedQuery = query;
    const before = isMore ? (this.#list?.volumes ?? []) : [];
    this.#problem = null;
    this.#isLoading = true;
    this.#render();
    try {
      const list = await withBackoff(
        () => fetchVolumes({ query, offset: before.length }, signal),
        signal,
        (error) => {
          this.#problem = listProblem(error);
          this.#render();
        },
      );
      // If a volume was added in the meantime, the others have moved: do not show one twice.
      const names = new Set(before.map(({ name }) => name));
      const added = list.volumes.filter(({ name }) => !names.has(name));
      this.#list = { ...list, volumes: [...before, ...added] };
      this.#shownQuery = query;
      if (query === "") this.#all = this.#list;
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

  #render(): void {
    const list = this.#list;
    const total = list?.total ?? 0;
    const left = total - (list?.volumes.length ?? 0);
    render(
      html`<div class="catalog">
        <header class="bar">${brand()}<span class="bar-space"></span>${languageChoice()}${themeButton()}</header>
        <main class="catalog-main">
          <div class="catalog-head">
            <div>
              <h1>${startTexts.volumes}</h1>
              <p class="quiet">
                ${this.#all ? summary(this.#all) : startTexts.lead}
              </p>
            </div>
            ${
              this.#all && this.#all.total > 6
                ? html`<wa-input
                    class="catalog-filter no-label"
                    size="s"
                    type="search"
                    placeholder=${startTexts.search}
                    label=${startTexts.searchLabel}
                    @input=${(event: Event) => this.#search((event.target as HTMLInputElement).value)}
                  ></wa-input>`
                : nothing
            }
          </div>
          ${this.#device}
          ${this.#problem ? problemCard(this.#problem, { retry: () => void this.#load() }) : nothing}
          ${
            this.#all?.keptAt
              ? html`<p class="empty" role="status">
                  ${startTexts.keptList(this.#all.keptAt.toLocaleString(document.documentElement.lang))}
                </p>`
              : nothing
          }
          ${list || this.#problem ? nothing : skeleton()}
          ${
            this.#all?.total === 0
              ? html`<p class="empty">
                  ${startTexts.noVolumes(html`<code>isosplat build VOLUME</code>`)}
                </p>`
              : nothing
          }
          ${
            this.#shownQuery !== "" && list
              ? html`<p class="empty" role="status">
                  ${
                    total === 0
                      ? startTexts.noMatch(this.#shownQuery)
                      : startTexts.matches(total, this.#shownQuery)
                  }
                </p>`
              : nothing
          }
          <ul class="cards">
            ${repeat(
              list?.volumes ?? [],
              ({ name }) => name,
              (volume) =>
                html`<li>${card(volume, this.#servedPicture(volume), () => this.#drawInstead(volume))}</li>`,
            )}
          </ul>
          ${
            left > 0
              ? html`<p class="more-volumes">
                  <wa-button
                    size="s"
                    appearance="outlined"
                    ?loading=${this.#isLoading}
                    @click=${() => void this.#load({ isMore: true })}
                    >${startTexts.showMore}</wa-button
                  >
                  <span class="quiet">${startTexts.notShown(left, total)}</span>
                </p>`
              : nothing
          }
          ${openByAddress()}
        </main>
      </div>`,
      this.#root,
    );
    for (const element of this.#root.querySelectorAll("a.card"))
      this.#cardObserver.observe(element);
  }
}

function listProblem(error: unknown): Problem {
  return { ...problemOf(error, startTexts.theList), offers: ["again"] };
}

function summary({ total, fileBytes }: VolumeList): string {
  return fileBytes > 0
    ? startTexts.onServer(total, formatBytes(fileBytes))
    : startTexts.count(total);
}

/**
 * `served`: the URL of the picture, unless this browser has one; `failed`: called if it cannot be
 * shown.
 */
function card(volume: VolumeEntry, served: string | null, failed: () => void): TemplateResult {
  const title = volume.title || volume.name;
  if (volume.error) {
    return html`<div class="card broken">
      <div class="card-picture">${icon("alert")}</div>
      <h2>${title}</h2>
      <p class="card-facts">${volume.error.message}</p>
    </div>`;
  }
  const voxels = volume.voxels?.reduce((product, n) => product * n, 1);
  const picture = (volume.contentId && thumbnail(volume.contentId)) || served;
  return html`<a class="card" data-name=${volume.name} href="?volume=${encodeURIComponent(volume.name)}">
    <div class="card-picture">
      ${picture ? html`<img src=${picture} alt="" loading="lazy" @error=${failed} />` : sparkline(volume)}
    </div>
    <h2>${title}</h2>
    <p class="card-facts">
      ${volume.voxels ? html`<span>${formatDims(volume.voxels)}</span>` : nothing}
      ${volume.type ? html`<span>${formatType(volume.type)}</span>` : nothing}
      ${volume.fileBytes ? html`<span>${formatBytes(volume.fileBytes)}</span>` : nothing}
    </p>
    <p class="card-facts quiet">
      ${voxels ? html`<span>${startTexts.voxels(formatCount(voxels))}</span>` : nothing}
      ${
        volume.range
          ? html`<span>${pageTexts.to(formatValue(volume.range[0]), formatValue(volume.range[1]))}${volume.units ? ` ${volume.units}` : ""}</span>`
          : nothing
      }
    </p>
  </a>`;
}

/** The histogram on a logarithmic scale. A card shows it until there is a picture of the volume. */
function sparkline(volume: VolumeEntry): TemplateResult | typeof nothing {
  const counts = volume.histogram?.counts;
  if (!counts || counts.length === 0) return nothing;
  const most = Math.log1p(Math.max(1, ...counts));
  const points = counts.map((count, i) => {
    const x = (100 * i) / Math.max(1, counts.length - 1);
    return `${x.toFixed(2)} ${(40 - (36 * Math.log1p(Math.max(0, count))) / most).toFixed(2)}`;
  });
  return html`<svg class="sparkline" viewBox="0 0 100 40" preserveAspectRatio="none" aria-hidden="true">
    <path d="M0 40 L${points.join(" L")} L100 40Z" />
  </svg>`;
}

function skeleton(): TemplateResult {
  return html`<ul class="cards" aria-busy="true" aria-label=${startTexts.loading}>
    ${[0, 1, 2, 3, 4, 5].map(() => html`<li class="card ghost"><div class="card-picture"></div></li>`)}
  </ul>`;
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
