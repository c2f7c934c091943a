import "./device.css";
import {
  buildRaw,
  filesKey,
  findVolumes,
  forbidOtherOrigins,
  hold,
  type InputFile,
  type KeptStore,
  keep,
  keptBlob,
  keptStores,
  listedFiles,
  NotKeptError,
  nameOf,
  type RawLayout,
  transferredFiles,
} from "../device/index.ts";
import { contentIdOf } from "../stream/file_source.ts";
import { beginsAsStore } from "../stream/transfer.ts";
import { DeviceSection } from "./device_section.ts";
import { deviceAddress, deviceTarget } from "./device_target.ts";
import { askRawLayout } from "./raw_dialog.ts";
import { SaveButton } from "./save_button.ts";
import { Task } from "./task_card.ts";
import { VolumePage } from "./volume_page.ts";

/** Bytes that hold a store's content id, and more. */
const headerBytes = 4096;

/**
 * Takes files that are dropped, pasted or chosen anywhere on the page: opens stores and sessions,
 * builds stores of others, and keeps what was built.
 */
export class DeviceFiles {
  #root: HTMLElement;
  #page: VolumePage | undefined;
  readonly section: DeviceSection;
  #task: Task | undefined;

  /** `page`: the volume that is shown, if one is. */
  constructor(root: HTMLElement, page?: VolumePage) {
    this.#root = root;
    this.#page = page;
    this.section = new DeviceSection({
      take: (files) => void this.#take(Promise.resolve(listedFiles(files))),
    });
    window.addEventListener("paste", ({ clipboardData }) => {
      if (clipboardData?.files.length) void this.#take(transferredFiles(clipboardData));
    });
    this.#listenToDrops();
    // A volume that was opened without loading the page again.
    window.addEventListener("popstate", () => location.reload());
  }

  #listenToDrops(): void {
    const hint = document.createElement("div");
    hint.className = "drop-hint";
    hint.textContent = "Drop a volume or a store: it is read here, nothing is uploaded";
    const hasFiles = (event: DragEvent) => event.dataTransfer?.types.includes("Files") ?? false;
    window.addEventListener("dragover", (event) => {
      if (!hasFiles(event)) return;
      event.preventDefault();
      document.body.append(hint);
    });
    window.addEventListener("dragleave", ({ relatedTarget }) => {
      if (relatedTarget === null) hint.remove(); // it has left the window
    });
    window.addEventListener("drop", (event) => {
      hint.remove();
      if (!hasFiles(event) || !event.dataTransfer) return;
      event.preventDefault();
      void this.#take(transferredFiles(event.dataTransfer));
    });
  }

  /** Opens a store of the list. Resolves to false if it is not on this device. */
  async openKept(id: string): Promise<boolean> {
    const found = await keptBlob(id);
    if (found) this.#show(found.store, found.blob);
    return found !== undefined;
  }

  async #take(files: Promise<InputFile[]>): Promise<void> {
    if (this.#task?.isRunning) return; // its card says what it is doing
    this.#task?.close(); // its card may still show an error
    const task = new Task("Reading");
    this.#task = task;
    try {
      const found = await files;
      const [first] = found;
      if (first && found.length === 1 && /\.json$/i.test(first.path)) {
        const { openSession } = await import("./open_session.ts");
        await openSession(first.file);
      } else {
        forbidOtherOrigins();
        await this.#open(found, task);
      }
      task.close();
    } catch (error) {
      if (task.signal.aborted) task.close();
      else task.fail(error instanceof Error ? error.message : String(error));
    }
  }

  async #open(files: readonly InputFile[], task: Task): Promise<void> {
    for (const { path, file } of files) {
      const header = new Uint8Array(await file.slice(0, headerBytes).arrayBuffer());
      if (!beginsAsStore(header)) continue;
      const contentId = contentIdOf(header);
      const store = { contentId, name: nameOf(path), bytes: file.size, keptAt: Date.now() };
      if (!(await keptBlob(contentId))) hold(store, file);
      await this.#openHeld(contentId);
      return;
    }
    const volumes = findVolumes(files);
    const candidate = volumes[0];
    const chosen = files.find(({ path }) => path === candidate?.path);
    if (!candidate || !chosen) throw new Error(nothingFound(files));
    if (volumes.length > 1) {
      throw new Error(
        `expected one volume, found ${volumes.length}: ${volumes
          .slice(0, 3)
          .map(({ path }) => path)
          .join(", ")}${volumes.length > 3 ? ", …" : ""}; drop them one at a time`,
      );
    }
    const layout = await askRawLayout(chosen);
    if (layout) await this.#build(chosen, layout, task);
  }

  /** Two tabs that are given the same file build it once. */
  async #build(chosen: InputFile, layout: RawLayout, task: Task): Promise<void> {
    const key = await filesKey([chosen], layout);
    const name = nameOf(chosen.path);
    task.shows(`Building ${name}`, "waiting: another tab builds the same volume");
    const { signal } = task;
    await navigator.locks.request(`isosplat-build-${key}`, { signal }, async () => {
      const known = (await keptStores()).find(({ filesKey }) => filesKey === key);
      if (known) return this.#openHeld(known.contentId);
      task.shows(`Building ${name}`, "starting");
      const { store: blob, report } = await buildRaw(chosen, layout, {
        signal,
        progress: (progress) => task.progress(progress, chosen.file.size),
      });
      const store: KeptStore = {
        contentId: report.contentId,
        name,
        bytes: report.storeBytes,
        voxels: layout.dims,
        type: layout.type,
        filesKey: key,
        keptAt: Date.now(),
      };
      hold(store, blob);
      let notKept: string | undefined;
      try {
        task.shows(`Keeping ${name} on this device`, "");
        await keep(store, blob, signal);
      } catch (error) {
        if (!(error instanceof NotKeptError)) throw error;
        notKept = `${error.message} It is open until this tab is closed.`;
      }
      await this.#openHeld(store.contentId);
      if (notKept) throw new Error(notKept);
    });
  }

  async #openHeld(id: string): Promise<void> {
    const found = await keptBlob(id);
    if (!found) throw new Error("the store was removed from this device: open its file again");
    history.pushState(null, "", `${location.pathname}?src=${deviceAddress}${id}`);
    this.#show(found.store, found.blob);
  }

  /** Shows a store in place of what the page has shown. */
  #show(store: KeptStore, blob: Blob): void {
    this.#page?.close();
    // What was shown may still change its own elements.
    const root = document.createElement("div");
    root.id = this.#root.id;
    this.#root.replaceWith(root);
    this.#root = root;
    const page = new VolumePage(root, deviceTarget(store, blob));
    this.#page = page;
    page.tools = new SaveButton(store, blob, () => page.info).element;
    void page.firstContent.then(() => page.loadOverlay());
    void import("./components.ts");
  }
}

function nothingFound(files: readonly InputFile[]): string {
  const names = files
    .slice(0, 3)
    .map(({ path }) => path)
    .join(", ");
  const found =
    files.length === 0
      ? "no files"
      : `${files.length} file${files.length === 1 ? "" : "s"}: ${names}${files.length > 3 ? ", …" : ""}`;
  return (
    `Expected a store (.isosplat) or raw voxels (.raw), found ${found}. ` +
    "Other formats: isosplat build FILE makes a store of them, which opens here."
  );
}
