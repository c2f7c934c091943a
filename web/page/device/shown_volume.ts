import { type KeptStore, keptBlob } from "../../device/kept_stores.ts";
import { deviceAddress, idOnDevice, type SceneTarget, type Target } from "../address/target.ts";
import { readUrl } from "../address/url_state.ts";
import { loadPart } from "../shell/load_part.ts";
import { prepareView } from "../volume/view.ts";
import { VolumePage } from "../volume/volume_page.ts";
import { deviceTarget } from "./device_target.ts";
import { SaveButton } from "./save_button.ts";

/**
 * The volume that the page shows, among stores of this device.
 *
 * If a store takes long to build, the page first shows a provisional store of fewer voxels: a
 * reduced copy, or the coarsest scale of the file. Call `openProvisional` with it, and later `open`
 * with the complete store, which must have the same `filesKey`. The complete store replaces the
 * provisional one, and camera, settings and steps of undo stay. The grids of both must cover the
 * same part of the world. If no complete store follows, the provisional one stays, with its
 * description; `leaveProvisional` returns to the previous content.
 *
 *     shown.openProvisional({ ...coarse, filesKey }, coarseBlob, "Preview: 64 × 64 × 32 of …");
 *     shown.open({ ...complete, filesKey }, completeBlob);
 */
export class ShownVolume {
  #root: HTMLElement;
  #page: VolumePage | undefined;
  #provisional: KeptStore | undefined;
  #leave = () => {};
  readonly #shows: (page: VolumePage) => void;

  /**
   * `page`: the page of the volume that is shown, if there is one. `shows` is called with this page, and with each
   * page that is shown later.
   */
  constructor(root: HTMLElement, page: VolumePage | undefined, shows: (page: VolumePage) => void) {
    this.#root = root;
    this.#page = page;
    this.#shows = shows;
    if (page) shows(page);
    window.addEventListener("popstate", () => void this.#onPopState());
  }

  get page(): VolumePage | undefined {
    return this.#page;
  }

  /** Whether a complete store is open, to which other layers can be added. */
  get isOpen(): boolean {
    return this.#provisional === undefined && Boolean(this.#page?.info);
  }

  /**
   * Prepares for a volume that will be shown soon: loads the code of its page, unless one is shown
   * already. See releaseView.
   */
  prepare(): void {
    if (this.#page) return;
    prepareView();
    void loadPart(() => import("../shell/components.ts"));
  }

  /**
   * Shows a store instead of the present one. `keepsAddress`: keeps the address; otherwise the
   * store gets a new one.
   */
  open(store: KeptStore, blob: Blob, { keepsAddress = false } = {}): void {
    const page = this.#page;
    const { filesKey } = this.#provisional ?? {};
    if (page && filesKey !== undefined && filesKey === store.filesKey) {
      this.#provisional = undefined;
      const src = keepsAddress ? undefined : deviceAddress + store.contentId;
      void page.replace(deviceTarget(store, blob), src);
      page.tools = new SaveButton(store, blob, page).element;
    } else {
      if (!keepsAddress) pushAddress(store);
      this.show(store, blob);
    }
  }

  /** `what`: a description of the store for the visitor. */
  openProvisional(store: KeptStore, blob: Blob, what: string, { keepsAddress = false } = {}): void {
    if (!keepsAddress) pushAddress(store);
    this.#showPage({ ...deviceTarget(store, blob), provisional: what });
    this.#provisional = store;
    this.#leave = keepsAddress ? () => location.assign(location.pathname) : () => history.back();
  }

  /**
   * Shows what the page showed before the provisional store, or the start page if the store has
   * kept the address. Without a provisional store, does nothing.
   */
  leaveProvisional(): void {
    if (this.#provisional) this.#leave();
  }

  /**
   * Shows a scene of this device. The scene is not kept, so the address is that of the start page. `bundle`: the
   * file of the scene, if it is a bundle.
   */
  openScene(target: SceneTarget, bundle?: Blob): void {
    history.pushState(null, "", location.pathname);
    const page = this.#showPage(target);
    if (bundle) page.tools = new SaveButton(target.name, bundle, page).element;
  }

  /** Shows a store at the present address. */
  show(store: KeptStore, blob: Blob): void {
    const page = this.#showPage(deviceTarget(store, blob));
    page.tools = new SaveButton(store, blob, page).element;
  }

  #showPage(target: Target): VolumePage {
    this.#page?.close();
    this.#provisional = undefined;
    // The previous page may still change its elements.
    const root = document.createElement("div");
    root.id = this.#root.id;
    this.#root.replaceWith(root);
    this.#root = root;
    const page = new VolumePage(root, target);
    this.#page = page;
    this.#shows(page);
    void page.firstContent.then(() => page.loadOverlay());
    void loadPart(() => import("../shell/components.ts"));
    return page;
  }

  /**
   * Shows the store of the address without reloading the page: a reload would lose stores that are
   * not kept.
   */
  async #onPopState(): Promise<void> {
    this.#page?.close(); // otherwise it would write its view to this address
    const id = idOnDevice(readUrl(location.search).src);
    const found = id === undefined ? undefined : await keptBlob(id);
    if (found) this.show(found.store, found.blob);
    else location.reload();
  }
}

/** An address that names the store already keeps its view: it may be that of a link. */
function pushAddress({ contentId }: KeptStore): void {
  if (idOnDevice(readUrl(location.search).src) === contentId) return;
  history.pushState(null, "", `${location.pathname}?src=${deviceAddress}${contentId}`);
}
