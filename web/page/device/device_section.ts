import { html, nothing, render } from "lit";
import { ref } from "lit/directives/ref.js";
import { repeat } from "lit/directives/repeat.js";
import {
  isPersistent,
  type KeptStore,
  listKept,
  onKeptChange,
  remove,
  removeRemains,
  type UnreadableStore,
} from "../../device/kept_stores.ts";
import { deviceTexts } from "../../texts/device.ts";
import { deviceErrorTexts } from "../../texts/device_errors.ts";
import { messageOf } from "../../texts/without_options.ts";
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
  #unreadable: readonly UnreadableStore[] = [];
  #isPersistent = false;
  /** What was removed without the visitor's word. */
  #remains = "";
  /** The store about whose removal the visitor is asked. */
  #asked: string | undefined;
  #notice = "";
  #expected: { name: string | undefined } | undefined;

  constructor(actions: DeviceSectionActions) {
    this.#actions = actions;
    this.element.className = "device";
    this.#render();
    onKeptChange(() => void this.#load());
    void this.#load();
    void this.#removeRemains();
  }

  /** Asks for the volume of a link, by its name if the link states it. */
  expects(name: string | undefined): void {
    this.#expected = { name };
    this.#render();
  }

  /** Sets a sentence above the list. */
  set notice(text: string) {
    this.#notice = text;
    this.#render();
  }

  async #load(): Promise<void> {
    const { stores, unreadable } = await listKept().catch(() => ({ stores: [], unreadable: [] }));
    this.#stores = stores;
    this.#unreadable = unreadable;
    this.#isPersistent = await isPersistent().catch(() => false);
    this.#render();
  }

  async #removeRemains(): Promise<void> {
    const count = await removeRemains().catch(() => 0);
    if (count === 0) return;
    this.#remains = deviceTexts.remainsRemoved(count);
    this.#render();
  }

  #render(): void {
    const stores = this.#stores;
    const bytes = stores.reduce((sum, store) => sum + store.bytes, 0);
    render(
      html`${this.#expected ? expectation(this.#expected.name) : nothing}
        <div class="device-drop">
          <p>
            <strong>${deviceTexts.drop}</strong>${deviceTexts.orChoose(
              this.#chooser(deviceTexts.chooseFiles, false),
              this.#chooser(deviceTexts.chooseFolder, true),
            )}
          </p>
          <p class="quiet">${deviceTexts.dropText}</p>
        </div>
        ${this.#notice ? html`<p class="list-note" role="alert">${this.#notice}</p>` : nothing}
        ${this.#remains ? html`<p class="list-note" role="status">${this.#remains}</p>` : nothing}
        ${
          stores.length + this.#unreadable.length === 0
            ? nothing
            : html`<h2>${deviceTexts.onDevice} <span class="quiet">${formatBytes(bytes)}</span></h2>
                <p class="quiet">
                  ${this.#isPersistent ? deviceTexts.onDevicePersistent : deviceTexts.onDeviceText}
                </p>
                <ul class="cards">
                  ${repeat(
                    stores,
                    ({ contentId }) => contentId,
                    (store) =>
                      html`<li class="device-card">
                        ${card(store)}${this.#removal(store.contentId, store.name)}
                      </li>`,
                  )}
                  ${repeat(
                    this.#unreadable,
                    ({ contentId }) => contentId,
                    ({ contentId, reason }) =>
                      html`<li class="device-card">
                        <div class="device-unreadable">
                          <h2>${contentId.slice(0, 8)}…</h2>
                          <p>${deviceTexts.unreadable(reason)}</p>
                        </div>
                        ${this.#removal(contentId, `${contentId.slice(0, 8)}…`)}
                      </li>`,
                  )}
                </ul>`
        }`,
      this.element,
    );
  }

  async #remove(id: string, name: string): Promise<void> {
    this.#asked = undefined;
    try {
      await remove(id);
    } catch (error) {
      const reason = messageOf(error);
      this.notice = deviceErrorTexts.notRemoved(name, reason);
      await this.#load();
    }
  }

  /** The button that removes a store, and the question before it does. */
  #removal(id: string, name: string) {
    const ask = (asked: string | undefined) => {
      this.#asked = asked;
      this.#render();
    };
    if (this.#asked !== id) {
      return html`<button
        type="button"
        class="device-remove"
        title=${deviceTexts.remove}
        aria-label=${deviceTexts.removeNamed(name)}
        @click=${() => ask(id)}
      >
        ${icon("trash")}
      </button>`;
    }
    return html`<div class="device-ask" role="alertdialog" aria-label=${deviceTexts.askRemove(name)}
      @keydown=${({ key }: KeyboardEvent) => key === "Escape" && ask(undefined)}>
      <p>${deviceTexts.askRemove(name)}</p>
      <button type="button" class="chip" @click=${() => void this.#remove(id, name)}>
        ${deviceTexts.doRemove}
      </button>
      <button type="button" class="chip" ${ref(focusWhenShown)} @click=${() => ask(undefined)}>
        ${deviceTexts.doKeep}
      </button>
    </div>`;
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

function focusWhenShown(element?: Element): void {
  (element as HTMLElement | undefined)?.focus();
}

function expectation(name: string | undefined) {
  return html`<div class="device-expected" role="alert">
    <h2>${deviceTexts.expectedTitle(name)}</h2>
    <p>${deviceTexts.expectedText}</p>
  </div>`;
}

function card(store: KeptStore) {
  const { contentId, name, bytes, voxels, type, isTemporary } = store;
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
        ${isTemporary ? html`<span>${deviceTexts.temporary}</span>` : nothing}
      </p>
    </a>`;
}
