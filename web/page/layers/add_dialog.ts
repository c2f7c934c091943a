import "../shell/dialog_form.css";
import { html, nothing, render, type TemplateResult } from "lit";
import { layersTexts } from "../../texts/layers.ts";
import { messageOf } from "../../texts/without_options.ts";
import type { LayerPlace } from "../address/layer_address.ts";
import { formatBytes, formatDims } from "../shell/format.ts";
import {
  fetchLists,
  type SceneEntry,
  type SceneList,
  type VolumeEntry,
  type VolumeList,
} from "../shell/volumes_api.ts";

export interface AddDialogActions {
  add(place: LayerPlace): void;
  /** Adds all layers of a scene of the server. */
  addScene(name: string): void;
  /** Files of this device; null while the code for them has not loaded. */
  takeFiles: ((files: readonly File[]) => void) | null;
}

/** Maximum number of volumes listed at a time. */
const mostListed = 50;
/** A search begins when its text has not changed for this time (ms). */
const typingPause = 200;

/** Asks which volume or scene to add: one of the server, one at an address, or files of this device. */
export async function openAddDialog(actions: AddDialogActions): Promise<void> {
  await import("../shell/components.ts");
  new AddDialog(actions).open();
}

class AddDialog {
  readonly #holder = document.createElement("div");
  readonly #actions: AddDialogActions;
  #list: VolumeList | null = null;
  #scenes: SceneList | null = null;
  #problem = "";
  #loading = new AbortController();
  #timer = 0;

  constructor(actions: AddDialogActions) {
    this.#actions = actions;
  }

  open(): void {
    document.body.append(this.#holder);
    this.#render();
    void this.#load("");
  }

  async #load(query: string): Promise<void> {
    this.#loading.abort();
    this.#loading = new AbortController();
    const { signal } = this.#loading;
    try {
      const { volumes, scenes } = await fetchLists({ query, limit: mostListed }, signal);
      this.#list = volumes;
      this.#scenes = scenes;
      this.#problem = "";
    } catch (error) {
      if (signal.aborted) return;
      this.#problem = messageOf(error);
    }
    this.#render();
  }

  #end(): void {
    clearTimeout(this.#timer);
    this.#loading.abort();
    this.#holder.remove();
  }

  #add(place: LayerPlace): void {
    this.#end();
    this.#actions.add(place);
  }

  #addScene(name: string): void {
    this.#end();
    this.#actions.addScene(name);
  }

  #render(): void {
    render(
      html`<wa-dialog
        label=${layersTexts.addTitle}
        open
        class="add-layer"
        @wa-after-hide=${(event: Event) => {
          if (event.target === this.#holder.firstElementChild) this.#end();
        }}
      >
        <div class="dialog-form">
          ${this.#problem ? html`<p role="alert">${this.#problem}</p>` : nothing}
          ${this.#volumes()} ${this.#address()} ${this.#files()}
        </div>
      </wa-dialog>`,
      this.#holder,
    );
  }

  #volumes(): TemplateResult {
    const { volumes = [], total = undefined } = this.#list ?? {};
    const scenes = this.#scenes?.scenes ?? [];
    const all = this.#list && (total ?? 0) + (this.#scenes?.total ?? 0);
    const left = (all ?? 0) - volumes.length - scenes.length;
    return html`<label
        >${layersTexts.ofServer}
        <input
          type="search"
          autofocus
          placeholder=${layersTexts.search}
          @input=${(event: Event) => {
            const { value } = event.currentTarget as HTMLInputElement;
            clearTimeout(this.#timer);
            this.#timer = window.setTimeout(() => void this.#load(value.trim()), typingPause);
          }}
      /></label>
      <ul class="add-layer-volumes" aria-label=${layersTexts.ofServer}>
        ${volumes.filter(({ error }) => !error).map((volume) => html`<li>${this.#volume(volume)}</li>`)}
        ${scenes.filter(({ error }) => !error).map((scene) => html`<li>${this.#scene(scene)}</li>`)}
      </ul>
      ${all === 0 ? html`<p class="quiet" role="status">${layersTexts.noVolume}</p>` : nothing}
      ${left > 0 ? html`<p class="quiet">${layersTexts.moreVolumes(left)}</p>` : nothing}`;
  }

  #volume({ name, title, voxels, fileBytes }: VolumeEntry): TemplateResult {
    const facts = [voxels && formatDims(voxels), fileBytes && formatBytes(fileBytes)];
    return html`<button
      type="button"
      class="add-layer-volume"
      @click=${() => this.#add({ volume: name })}
    >
      <span>${title || name}</span> <span class="quiet">${facts.filter(Boolean).join(" · ")}</span>
    </button>`;
  }

  #scene({ name, title, layers, steps, fileBytes }: SceneEntry): TemplateResult {
    const facts = [
      layers !== undefined && layersTexts.sceneOf(layers),
      steps !== undefined && layersTexts.steps(steps),
      fileBytes && formatBytes(fileBytes),
    ];
    return html`<button type="button" class="add-layer-volume" @click=${() => this.#addScene(name)}>
      <span>${title || name}</span> <span class="quiet">${facts.filter(Boolean).join(" · ")}</span>
    </button>`;
  }

  #address(): TemplateResult {
    const submit = (event: Event) => {
      event.preventDefault();
      const form = event.currentTarget as HTMLFormElement;
      const src = form.querySelector("input")?.value.trim();
      if (src) this.#add({ src });
    };
    return html`<form class="add-layer-address" @submit=${submit}>
      <label
        >${layersTexts.address}
        <input type="url" required placeholder="https://example.org/head.isosplat"
      /></label>
      <wa-button type="submit" size="s" appearance="outlined">${layersTexts.addAddress}</wa-button>
    </form>`;
  }

  #files(): TemplateResult | typeof nothing {
    const { takeFiles } = this.#actions;
    if (!takeFiles) return nothing;
    return html`<label class="chip add-layer-files"
      >${layersTexts.files}<input
        class="visually-hidden"
        type="file"
        multiple
        @change=${(event: Event) => {
          const files = [...((event.currentTarget as HTMLInputElement).files ?? [])];
          this.#end();
          if (files.length > 0) takeFiles(files);
        }}
    /></label>`;
  }
}
