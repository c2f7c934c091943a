import "./device.css";
import { nameAt } from "../../device/fetch_file.ts";
import { type InputFile, isZip, listedFiles, transferredFiles } from "../../device/files.ts";
import { onHandedOver } from "../../device/handed_over.ts";
import {
  hold,
  type KeptStore,
  keep,
  keptBlob,
  keptStores,
  NotKeptError,
} from "../../device/kept_stores.ts";
import { forbidOtherOrigins, isForbiddenAddress } from "../../device/no_upload.ts";
import {
  findVolumes,
  nameOf,
  openVolume,
  type ReadableVolume,
  warmUp,
} from "../../device/reading.ts";
import { RemoteFiles } from "../../device/remote_files.ts";
import {
  addressOfScale,
  isZarr,
  openZarr,
  zarrFolder,
  zarrVolume,
} from "../../device/zarr_volume.ts";
import { isBundleName, isSceneName } from "../../scene/scene_name.ts";
import { contentIdOf } from "../../stream/file_source.ts";
import { beginsAsStore } from "../../stream/transfer.ts";
import { StreamError } from "../../stream/types.ts";
import { deviceTexts } from "../../texts/device.ts";
import { messageOf } from "../../texts/without_options.ts";
import { addressIn } from "../address/open_target.ts";
import { deviceAddress, idOnDevice } from "../address/target.ts";
import { readUrl } from "../address/url_state.ts";
import { formatDims } from "../shell/format.ts";
import { loadPart } from "../shell/load_part.ts";
import { releaseView } from "../volume/view.ts";
import type { VolumePage } from "../volume/volume_page.ts";
import { addressedScene } from "./addressed_scene.ts";
import {
  chooseInFile,
  chooseInZarr,
  chooseManner,
  chooseScale,
  chooseVolume,
  type Manner,
  nothingFound,
  rejectOpening,
} from "./choose_volume.ts";
import { DeviceSection } from "./device_section.ts";
import { askRawLayout } from "./raw_dialog.ts";
import { ShownVolume } from "./shown_volume.ts";
import { Task } from "./task_card.ts";

/** The URL from which files were fetched. */
interface Origin {
  address: URL;
  version: string | undefined;
  remote: RemoteFiles;
}

/** The origin of a volume, as a kept store states it. */
type StoredOrigin = Pick<KeptStore, "address" | "version">;

/** A store's first bytes, which include its content id. */
const headerBytes = 4096;

/**
 * Handles files that are dropped, pasted or chosen anywhere on the page: opens stores and sessions,
 * builds stores of other files, and keeps the stores that were built.
 */
export class DeviceFiles {
  readonly #shown: ShownVolume;
  readonly section: DeviceSection;
  #task: Task | undefined;
  /** Whether the running task adds its volume to the picture, or replaces the open one. */
  #manner: Manner = "replace";
  /** Aborts the preview of a volume. */
  #previewing: AbortController | undefined;

  /** `page`: the page of the volume that is shown, if there is one. */
  constructor(root: HTMLElement, page?: VolumePage) {
    this.#shown = new ShownVolume(root, page, (shown) => {
      shown.layers.takeFiles = (files) =>
        void this.#take(Promise.resolve(listedFiles(files)), "add");
    });
    this.section = new DeviceSection({
      take: (files) => void this.#take(Promise.resolve(listedFiles(files))),
    });
    window.addEventListener("paste", ({ clipboardData }) => {
      if (clipboardData?.files.length) void this.#take(transferredFiles(clipboardData));
    });
    this.#listenToDrops();
    onHandedOver((files) => void this.#take(Promise.resolve(listedFiles(files))));
    void loadPart(() => import("../shell/offline.ts")).then(({ startOffline }) => startOffline());
  }

  #listenToDrops(): void {
    const hint = document.createElement("div");
    hint.className = "drop-hint";
    hint.textContent = deviceTexts.dropHere;
    const hasFiles = (event: DragEvent) => event.dataTransfer?.types.includes("Files") ?? false;
    window.addEventListener("dragover", (event) => {
      if (!hasFiles(event)) return;
      event.preventDefault();
      document.body.append(hint);
    });
    window.addEventListener("dragleave", ({ relatedTarget }) => {
      if (relatedTarget === null) hint.remove(); // the pointer has left the window
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
    if (found) this.#shown.show(found.store, found.blob);
    return found !== undefined;
  }

  /** The content id of the volume for which the page of a link waits: its view is shown once the file is there. */
  get #expected(): string | undefined {
    return this.#shown.page ? undefined : idOnDevice(readUrl(location.search).src);
  }

  /** Opens the volume at a URL: fetches it, or opens its kept store. */
  openAddress(address: URL): Promise<void> {
    return this.#run(deviceTexts.fetching, async (task) => {
      this.#manner = "replace";
      const kept = (await keptStores()).filter((store) => store.address === address.href);
      task.shows(deviceTexts.fetchingNamed(nameAt(address)), deviceTexts.from(address.host));
      try {
        if (isZarr(address)) await this.#openZarr(address, task);
        else await this.#openFile(address, kept, task);
      } catch (error) {
        const isOffline = error instanceof StreamError && error.kind === "unreachable";
        if (!isOffline || !kept[0] || !(await this.openKept(kept[0].contentId))) throw error;
        task.fail(deviceTexts.unreachable(address.host), deviceTexts.fromDevice);
      }
    });
  }

  async #openFile(address: URL, kept: readonly KeptStore[], task: Task): Promise<void> {
    const remote = new RemoteFiles(address, {
      signal: task.signal,
      progress: (name, received, bytes) =>
        task.fetching(deviceTexts.fetchingNamed(name), received, bytes),
    });
    const isKept = (version: string) => kept.some((store) => store.version === version);
    const { file, version } = await remote.first(isKept);
    const known = kept.find((store) => store.version === version);
    if (file) await this.#open([file], task, { address, version, remote });
    else if (known) await this.openKept(known.contentId);
  }

  /** The address bar shows the URL of the chosen scale. */
  async #openZarr(address: URL, task: Task): Promise<void> {
    const image = await openZarr(address, task.signal);
    const scale = await chooseScale(image);
    if (!scale) return;
    const scaleAddress = addressOfScale(image, scale, address);
    const { pathname, search } = location;
    const query = new URLSearchParams(search);
    query.set("src", scaleAddress.href);
    history.replaceState(null, "", `${pathname}?${query}`);
    await this.#build(await zarrVolume(image, scale, scaleAddress), task, {
      address: scaleAddress.href,
    });
  }

  /** If `manner` is undefined and a volume is open, asks the visitor. */
  #take(files: Promise<InputFile[]>, manner?: Manner): Promise<void> {
    return this.#run(deviceTexts.reading, async (task) => {
      const found = await files;
      const [first] = found;
      const scene = first && found.length === 1 ? await addressedScene(first.file) : null;
      if (scene) {
        this.#shown.openScene({ name: scene.name, scene: async () => scene });
      } else if (first && found.length === 1 && isSession(first.path)) {
        const { openSession } = await import("../address/open_session.ts");
        await openSession(first.file);
      } else if (found.some(({ path }) => isSceneName(path))) {
        await this.#openScene(found);
      } else {
        const chosen = manner ?? (await this.#chooseManner(task));
        if (!chosen) return;
        this.#manner = chosen;
        forbidOtherOrigins();
        await this.#open(found, task);
      }
    });
  }

  async #openScene(files: readonly InputFile[]): Promise<void> {
    forbidOtherOrigins();
    const { sceneOfFiles } = await import("../../scene/scene_source.ts");
    const scene = sceneOfFiles(files);
    const bundle = files.find(({ path }) => isBundleName(path))?.file;
    if (scene) this.#shown.openScene({ name: scene.name, scene: async () => scene }, bundle);
  }

  /** If the open volume cannot be shown with others, the new ones replace it. */
  async #chooseManner(task: Task): Promise<Manner | undefined> {
    if (!this.#shown.isOpen || hasOtherOrigins(this.#shown.page)) return "replace";
    task.shows(deviceTexts.besideOpen, "");
    return chooseManner();
  }

  async #run(title: string, work: (task: Task) => Promise<void>): Promise<void> {
    if (this.#task?.isRunning) {
      this.#task.remarks(deviceTexts.oneAtATime);
      return;
    }
    this.#task?.close(); // its card may still show an error
    this.#previewing?.abort();
    const task = new Task(title);
    this.#task = task;
    const before = this.#shown.page;
    try {
      await work(task);
      if (task.isRunning) task.close();
    } catch (error) {
      const cut = this.#shown.page === before ? hostCutOff() : undefined;
      if (cut)
        task.fail(
          `${task.signal.aborted ? deviceTexts.cancelled : messageOf(error)} ${deviceTexts.cutOff(cut)}`,
        );
      else if (task.signal.aborted) {
        task.close();
        this.#shown.leaveProvisional();
      } else task.failed(error);
    } finally {
      releaseView();
    }
  }

  async #open(given: readonly InputFile[], task: Task, origin?: Origin): Promise<void> {
    const files = await this.#unzipped(given, task);
    for (const { path, file } of files) {
      if (files.length > 1 && !path.endsWith(".isosplat")) continue;
      const header = new Uint8Array(await file.slice(0, headerBytes).arrayBuffer());
      if (!beginsAsStore(header)) continue;
      const contentId = contentIdOf(header);
      const store = { contentId, name: nameOf(path), bytes: file.size, keptAt: Date.now() };
      if (!(await keptBlob(contentId))) hold(store, file);
      await this.#openHeld(contentId);
      return;
    }
    warmUp();
    this.#shown.prepare();
    task.shows(deviceTexts.reading, deviceTexts.files(files.length));
    const folder = zarrFolder(files);
    if (folder !== undefined) {
      const volume = await chooseInZarr(folder, files, task.signal);
      if (volume) await this.#build(volume, task, {});
      return;
    }
    const volumes = await findVolumes(files, task.signal);
    const volume = volumes.length === 0 ? await nothingFound(files) : await chooseVolume(volumes);
    if (!volume) return;
    const raw = volume.needsDims ? files.find((each) => each.path === volume.path) : undefined;
    const layout = raw && (await askRawLayout(raw));
    if (raw && !layout) return;
    const find = origin && ((missing: string) => origin.remote.find(missing));
    const { path } = volume;
    const opened = await openVolume(files, volume, layout, task.signal, chooseInFile, find).catch(
      (error) => rejectOpening(error, files, path),
    );
    if (!opened) return;
    try {
      // If no choice was made, the URL alone identifies the volume.
      const isOfAddress = origin && volumes.length === 1 && !layout && !opened.isChosen;
      await this.#build(opened, task, isOfAddress ? storedOrigin(origin, opened) : {});
    } finally {
      opened.close();
    }
  }

  /** The files, with each ZIP replaced by its contents. */
  async #unzipped(files: readonly InputFile[], task: Task): Promise<readonly InputFile[]> {
    const zip = files.find(isZip);
    if (!zip) return files;
    task.shows(deviceTexts.unpacking(nameOf(zip.path)), "");
    const { unzipped } = await import("../../device/unzip.ts");
    const found = await unzipped(files, {
      signal: task.signal,
      progress: (done, bytes) =>
        task.fetching(deviceTexts.unpacking(nameOf(zip.path)), done, bytes),
    });
    performance.mark("isosplat:unpacked");
    return found;
  }

  /** If two tabs get the same files, their volume is built only once. */
  async #build(volume: ReadableVolume, task: Task, stored: StoredOrigin): Promise<void> {
    const { key, description } = volume;
    const { name } = description;
    task.shows(deviceTexts.building(name), deviceTexts.otherTab);
    const { signal } = task;
    await navigator.locks.request(`isosplat-build-${key}`, { signal }, async () => {
      const known = (await keptStores()).find(({ filesKey }) => filesKey === key);
      if (known) return this.#openHeld(known.contentId, stored);
      task.shows(deviceTexts.building(name), deviceTexts.starting);
      const previewing = new AbortController();
      this.#previewing = previewing;
      signal.addEventListener("abort", () => previewing.abort());
      const { store: blob, report } = await volume.build(
        { signal, progress: (progress) => task.progress(progress, volume.voxelBytes) },
        previewing.signal,
        (built, voxels) =>
          // The view of a link is for its volume alone.
          this.#manner === "replace" &&
          this.#expected === undefined &&
          this.#shown.openProvisional(
            {
              contentId: built.report.contentId,
              name,
              bytes: built.store.size,
              filesKey: key,
              keptAt: Date.now(),
            },
            built.store,
            deviceTexts.preview(formatDims(voxels), formatDims(description.voxels)),
            { keepsAddress: stored.address !== undefined },
          ),
      );
      previewing.abort();
      const store: KeptStore = {
        contentId: report.contentId,
        name,
        bytes: report.storeBytes,
        voxels: description.voxels,
        type: description.type,
        filesKey: key,
        ...stored,
        keptAt: Date.now(),
      };
      hold(store, blob);
      performance.mark("isosplat:built");
      await this.#openHeld(store.contentId, stored);
      try {
        task.shows(deviceTexts.keeping(name), "");
        await keep(store, blob, signal);
      } catch (error) {
        if (!(error instanceof NotKeptError)) throw error;
        task.fail(`${messageOf(error)} ${deviceTexts.untilClosed}`, deviceTexts.notKept);
      }
    });
  }

  /** For a fetched volume, the address bar keeps its URL, so that others can open it as well. */
  async #openHeld(id: string, { address }: StoredOrigin = {}): Promise<void> {
    const found = await keptBlob(id);
    if (!found) throw new Error(deviceTexts.removed);
    const { page } = this.#shown;
    if (page && this.#manner === "add") {
      await page.layers.add({ src: deviceAddress + id });
      return;
    }
    const expected = this.#expected;
    this.#shown.open(found.store, found.blob, { keepsAddress: address !== undefined });
    if (expected !== undefined && expected !== id) {
      this.#task?.fail(deviceTexts.notOfLink(found.store.name), deviceTexts.otherThanLink);
    }
  }
}

function isSession(path: string): boolean {
  return /\.json$/i.test(path) && !isSceneName(path);
}

/** The version is that of a single file. Several files would have to be checked one by one. */
function storedOrigin({ address, version }: Origin, { files }: ReadableVolume): StoredOrigin {
  return { address: address.href, ...(version && files === 1 ? { version } : {}) };
}

/**
 * Whether the page shows stores of other hosts. Once files of this device are read, nothing more
 * can be fetched from these hosts.
 */
function hasOtherOrigins(page: VolumePage | undefined): boolean {
  const added = page?.layers.view?.present.map(({ place }) => place.src) ?? [];
  return [readUrl(location.search).src, ...added].some((src) => {
    const address = src === undefined ? undefined : addressIn(src);
    return address !== undefined && address.origin !== location.origin;
  });
}

/** The host of the volume that is shown, if the browser refuses requests to it from now on. */
function hostCutOff(): string | undefined {
  const { src = "" } = readUrl(location.search);
  const address = addressIn(src);
  return address && isForbiddenAddress(address) ? address.host : undefined;
}
