import { type KeptStore, keptBlob } from "../../device/kept_stores.ts";
import type { Target } from "../address/target.ts";
import { readUrl } from "../address/url_state.ts";
import { prepareView } from "../volume/view.ts";
import { VolumePage } from "../volume/volume_page.ts";
import { deviceAddress, deviceTarget } from "./device_target.ts";
import { SaveButton } from "./save_button.ts";

/**
 * The volume that the page shows, among stores of this device.
 *
 * A volume whose store takes long to build is shown at once as a provisional store of fewer voxels: a
 * reduced copy, or the coarsest scale of its file. Call `openProvisional` with it, and later `open` with
 * the complete store, whose `filesKey` is the same: it takes the place of the other, and camera,
 * settings and steps of undo stay. The grids of both have to cover the same part of the world. If no
 * complete store comes, the provisional one stays, and says what it is; `leaveProvisional` returns to
 * what was shown before.
 *
 *     shown.openProvisional({ ...coarse, filesKey }, coarseBlob, "Preview: 64 × 64 × 32 of …");
 *     shown.open({ ...complete, filesKey }, completeBlob);
 */
export class ShownVolume {
  #root: HTMLElement;
  #page: VolumePage | undefined;
  #provisional: KeptStore | undefined;
  #leave = () => {};

  /** `page`: the volume that is shown, if one is. */
  constructor(root: HTMLElement, page?: VolumePage) {
    this.#root = root;
    this.#page = page;
    window.addEventListener("popstate", () => void this.#onPopState());
  }

  get page(): VolumePage | undefined {
    return this.#page;
  }

  /** A volume will be shown in a moment: loads what its page needs, unless one is shown already. See releaseView. */
  prepare(): void {
    if (this.#page) return;
    prepareView();
    void import("../shell/components.ts");
  }

  /** Shows a store in place of what the page has shown. `keepsAddress`: else its own is a new one. */
  open(store: KeptStore, blob: Blob, { keepsAddress = false } = {}): void {
    const page = this.#page;
    const { filesKey } = this.#provisional ?? {};
    if (page && filesKey !== undefined && filesKey === store.filesKey) {
      this.#provisional = undefined;
      const src = keepsAddress ? undefined : deviceAddress + store.contentId;
      void page.replace(deviceTarget(store, blob), src);
      page.tools = new SaveButton(store, blob, () => page.info).element;
    } else {
      if (!keepsAddress) pushAddress(store);
      this.show(store, blob);
    }
  }

  /** `what`: what the store is, in words for the visitor. */
  openProvisional(store: KeptStore, blob: Blob, what: string, { keepsAddress = false } = {}): void {
    if (!keepsAddress) pushAddress(store);
    this.#showPage({ ...deviceTarget(store, blob), provisional: what });
    this.#provisional = store;
    this.#leave = keepsAddress ? () => location.assign(location.pathname) : () => history.back();
  }

  /**
   * Shows what was shown before the provisional store; the start page if it has kept the address.
   * Without a provisional store, nothing happens.
   */
  leaveProvisional(): void {
    if (this.#provisional) this.#leave();
  }

  /** Shows a store at the present address. */
  show(store: KeptStore, blob: Blob): void {
    const page = this.#showPage(deviceTarget(store, blob));
    page.tools = new SaveButton(store, blob, () => page.info).element;
  }

  #showPage(target: Target): VolumePage {
    this.#page?.close();
    this.#provisional = undefined;
    // What was shown may still change its own elements.
    const root = document.createElement("div");
    root.id = this.#root.id;
    this.#root.replaceWith(root);
    this.#root = root;
    const page = new VolumePage(root, target);
    this.#page = page;
    void page.firstContent.then(() => page.loadOverlay());
    void import("../shell/components.ts");
    return page;
  }

  /** A store that is not kept would be lost if the page were loaded again. */
  async #onPopState(): Promise<void> {
    this.#page?.close(); // it would write its view into this address
    const { src } = readUrl(location.search);
    const id = src?.startsWith(deviceAddress) ? src.slice(deviceAddress.length) : undefined;
    const found = id === undefined ? undefined : await keptBlob(id);
    if (found) this.show(found.store, found.blob);
    else location.reload();
  }
}

function pushAddress({ contentId }: KeptStore): void {
  history.pushState(null, "", `${location.pathname}?src=${deviceAddress}${contentId}`);
}
