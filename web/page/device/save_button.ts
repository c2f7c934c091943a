import { html, nothing, render } from "lit";
import type { StoreInfo } from "../../core/types.ts";
import { type KeptStore, keep, keptBlob } from "../../device/kept_stores.ts";
import { deviceTexts } from "../../texts/device.ts";
import { messageOf } from "../../texts/without_options.ts";
import { iconButton } from "../shell/chrome.ts";
import { formatBytes } from "../shell/format.ts";
import { thumbnail } from "../shell/thumbnails.ts";

type Dialog = HTMLElement & { open: boolean };

/**
 * The bar's button for a store of this device, and its dialog: keep it, or save it as a file. A bundle, which is
 * a file already, can be saved as a single page.
 */
export class SaveButton {
  readonly element = document.createElement("span");
  readonly #store: KeptStore | null;
  readonly #fileName: string;
  readonly #blob: Blob;
  readonly #page: { info: StoreInfo | null; view: string };
  readonly #holder = document.createElement("div");
  #message = "";
  #isKept = true;
  #busy = "";
  #bytes: { site: number; page: number } | undefined;

  /** `saved`: a store, or the name of a bundle. `page`: the page that shows it, with its present view as a query. */
  constructor(
    saved: KeptStore | string,
    blob: Blob,
    page: { info: StoreInfo | null; view: string },
  ) {
    this.#store = typeof saved === "string" ? null : saved;
    const name = typeof saved === "string" ? saved.replace(/\.isobundle$/i, "") : saved.name;
    this.#fileName = name.replace(/[^\w.-]+/g, "-") || "volume";
    this.#blob = blob;
    this.#page = page;
    const action = () => void this.#open();
    render(iconButton({ icon: "save", label: this.#label, action }), this.element);
  }

  get #label(): string {
    return this.#store ? deviceTexts.saveVolume : deviceTexts.saveScenePage;
  }

  async #open(): Promise<void> {
    await import("../shell/components.ts");
    document.body.append(this.#holder);
    this.#message = "";
    this.#render();
    (this.#holder.firstElementChild as Dialog).open = true;
    this.#isKept = !this.#store || !(await keptBlob(this.#store.contentId))?.store.isTemporary;
    this.#render();
    try {
      const { siteBytes } = await import("../../device/save_site.ts");
      const { singlePageBytes } = await import("../../device/save_single_page.ts");
      const { size } = this.#blob;
      this.#bytes = { site: await siteBytes(size), page: await singlePageBytes(size) };
    } catch (error) {
      this.#message = messageOf(error);
    }
    this.#render();
  }

  #render(): void {
    const bytes = this.#bytes;
    const size = (n: number | undefined) => (n === undefined ? "" : formatBytes(n));
    render(
      html`<wa-dialog label=${this.#label} light-dismiss>
        ${
          this.#isKept
            ? nothing
            : this.#option(
                deviceTexts.keepTitle,
                deviceTexts.keepText,
                size(this.#blob.size),
                () => this.#keep(),
                deviceTexts.keepVerb,
              )
        }
        ${
          this.#store
            ? this.#option(deviceTexts.store, deviceTexts.storeText, size(this.#blob.size), () =>
                this.#download(this.#blob, "isosplat"),
              )
            : nothing
        }
        ${this.#option(
          deviceTexts.singlePage,
          this.#store ? deviceTexts.singlePageText : deviceTexts.scenePageText,
          size(bytes?.page),
          async () => {
            const { singlePage } = await import("../../device/save_single_page.ts");
            const { view } = this.#page;
            await this.#download(await singlePage(this.#blob, this.#fileName, view), "html");
          },
        )}
        ${
          this.#store
            ? this.#option(deviceTexts.webSite, deviceTexts.webSiteText, size(bytes?.site), () =>
                this.#saveSite(),
              )
            : nothing
        }
        <p role="status">${this.#busy || this.#message}</p>
      </wa-dialog>`,
      this.#holder,
    );
  }

  #option(
    title: string,
    text: string,
    size: string,
    action: () => Promise<void>,
    verb = deviceTexts.saveVerb,
  ) {
    return html`<section class="save-option">
      <strong>${title} <span class="quiet">${size}</span></strong>
      <wa-button
        size="s"
        appearance="outlined"
        ?disabled=${this.#busy !== ""}
        @click=${() => void this.#run(title, action)}
        ><span class="visually-hidden">${title}: </span>${verb}</wa-button
      >
      <p class="quiet">${text}</p>
    </section>`;
  }

  async #run(title: string, action: () => Promise<void>): Promise<void> {
    this.#busy = deviceTexts.preparing(title);
    this.#message = "";
    this.#render();
    try {
      await action();
      this.#message = deviceTexts.done(title);
    } catch (error) {
      this.#message = messageOf(error);
    }
    this.#busy = "";
    this.#render();
  }

  async #saveSite(): Promise<void> {
    const { info } = this.#page;
    if (!info) throw new Error(deviceTexts.notOpenYet);
    const { siteZip } = await import("../../device/save_site.ts");
    const picture = thumbnail(info.contentId);
    await this.#download(await siteZip(this.#blob, info, this.#fileName, picture), "zip");
  }

  async #keep(): Promise<void> {
    if (!this.#store) return;
    const { info } = this.#page;
    const type = info?.metadata.source?.type;
    await keep(
      {
        ...this.#store,
        ...(info && { voxels: info.voxels }),
        ...(typeof type === "string" && { type }),
      },
      this.#blob,
    );
    this.#isKept = true;
  }

  async #download(blob: Blob, suffix: string): Promise<void> {
    const link = document.createElement("a");
    link.href = URL.createObjectURL(blob);
    link.download = `${this.#fileName}.${suffix}`;
    link.click();
    setTimeout(() => URL.revokeObjectURL(link.href), 60_000);
  }
}
