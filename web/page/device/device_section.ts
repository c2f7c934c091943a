import { html, nothing, render } from "lit";
import { repeat } from "lit/directives/repeat.js";
import { type KeptStore, keptStores, onKeptChange, remove } from "../../device/kept_stores.ts";
import { deviceTexts } from "../../texts/device.ts";
import { deviceAddress } from "../address/target.ts";
import { formatBytes, formatDims, formatType } from "../shell/format.ts";
import { icon } from "../shell/icons.ts";
import { thumbnail } from "../shell/thumbnails.ts";

export interface DeviceSectionActions {
  take(files: Iterable<File>): void;
}

/**
 * The section of the start page for files of this device: a drop area, and the list of kept stores.
 */
export class DeviceSection {
  readonly element = document.createElement("section");
  readonly #actions: DeviceSectionActions;
  #stores: readonly KeptStore[] = [];
  #notice = "";

  constructor(actions: DeviceSectionActions) {
    this.#actions = actions;
    this.element.className = "device";
    this.#render();
    onKeptChange(() => void this.#load());
    void this.#load();
  }

  /** Sets a sentence above the list. */
  set notice(text: string) {
    this.#notice = text;
    this.#render();
  }

  async #load(): Promise<void> {
    this.#stores = await keptStores().catch(() => []);
    this.#render();
  }

  #render(): void {
    const stores = this.#stores;
    const bytes = stores.reduce((sum, store) => sum + store.bytes, 0);
    render(
      html`<div class="device-drop">
          <p>
            <strong>${deviceTexts.drop}</strong>${deviceTexts.orChoose(
              this.#chooser(deviceTexts.chooseFiles, false),
              this.#chooser(deviceTexts.chooseFolder, true),
            )}
          </p>
          <p class="quiet">${deviceTexts.dropText}</p>
        </div>
        ${this.#notice ? html`<p class="empty" role="alert">${this.#notice}</p>` : nothing}
        ${
          stores.length === 0
            ? nothing
            : html`<h2>${deviceTexts.onDevice} <span class="quiet">${formatBytes(bytes)}</span></h2>
                <p class="quiet">${deviceTexts.onDeviceText}</p>
                <ul class="cards">
                  ${repeat(
                    stores,
                    ({ contentId }) => contentId,
                    (store) => html`<li class="device-card">${card(store)}</li>`,
                  )}
                </ul>`
        }`,
      this.element,
    );
  }

  #chooser(label: string, isFolder: boolean) {
    return html`<label class="device-choose"
      >${label}<input
        class="visually-hidden"
        type="file"
        multiple
        ?webkitdirectory=${isFolder}
        @change=${(event: Event) => {
          const input = event.currentTarget as HTMLInputElement;
          const files = [...(input.files ?? [])];
          input.value = ""; // the same file may be chosen again
          if (files.length > 0) this.#actions.take(files);
        }}
    /></label>`;
  }
}

function card(store: KeptStore) {
  const { contentId, name, bytes, voxels, type } = store;
  const picture = thumbnail(contentId);
  return html`<a class="card" href="?src=${deviceAddress}${contentId}">
      <div class="card-picture">
        ${picture ? html`<img src=${picture} alt="" />` : nothing}
      </div>
      <h2>${name}</h2>
      <p class="card-facts">
        ${voxels ? html`<span>${formatDims(voxels)}</span>` : nothing}
        ${type ? html`<span>${formatType(type)}</span>` : nothing}
        <span>${formatBytes(bytes)}</span>
      </p>
    </a>
    <button
      type="button"
      class="device-remove"
      title=${deviceTexts.remove}
      aria-label=${deviceTexts.removeNamed(name)}
      @click=${() => void remove(contentId)}
    >
      ${icon("trash")}
    </button>`;
}
