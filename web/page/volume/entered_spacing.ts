import type { StoreInfo, Triple } from "../../core/types.ts";
import { readMeasurement, writeMeasurement } from "../../measure/measurement_text.ts";
import { movedMeasurement } from "../../measure/moved_measurement.ts";
import { unitOf } from "../../overlay/length_unit.ts";
import type { Source } from "../../stream/source.ts";
import { respacing } from "../../viewer/respacing.ts";
import { sameValue } from "../../viewer/same_value.ts";
import type { Viewer } from "../../viewer/viewer.ts";
import type { AddressState } from "../address/page_address.ts";
import { inUnit, millimetresOf, type UnitSpacing } from "../address/spacing_units.ts";
import type { UrlState } from "../address/url_state.ts";
import type { askSpacing as Ask } from "../panel/spacing_dialog.ts";
import { keepSpacing, keptSpacing } from "./kept_spacing.ts";
import type { LoadedParts } from "./loaded_parts.ts";
import type { PageCamera } from "./page_camera.ts";

/**
 * Opens the source with the spacing of the address, or the one that was entered on this device before, if the
 * volume's file states none. Once the visitor has chosen one in this page, or none, it is the address's.
 */
export function takeSpacing(source: Source, url: UrlState): void {
  source.spacingOf = (info) =>
    unitOf(info) === "voxel"
      ? (url.spacing ?? (url.isSpacingChosen ? undefined : keptLengths(info.contentId)))
      : undefined;
}

function millimetres(entered: UnitSpacing | undefined): Triple | undefined {
  return entered && millimetresOf(entered);
}

function keptLengths(contentId: string): Triple | undefined {
  return millimetres(keptSpacing(contentId));
}

function givenSpacing({ isSpacingGiven, spacing }: StoreInfo): Triple | undefined {
  return isSpacingGiven ? spacing : undefined;
}

/** A view of the history. */
type SpacingView = Pick<AddressState, "spacing" | "keptSpacing" | "camera">;

export interface EnteredSpacingHost {
  /** A view that has not come to rest is a step of undo as well. */
  rest(): void;
  /** Opens the volume again, with the spacing in the address and the present view. Resolves to false if it fails. */
  reopen(): Promise<boolean>;
  readonly camera: Pick<PageCamera, "isWhole" | "refit">;
  /** The volume could not be opened: shows the view before, which the address still has. */
  failed(): void;
  /** The dialog could not be loaded. */
  noDialog(): void;
  /** The volume is open with the other spacing. */
  changed(): void;
}

/** The distances between voxels that the visitor enters for a volume whose file states none. */
export class EnteredSpacing {
  readonly #viewer: Viewer;
  readonly #url: UrlState;
  readonly #parts: Pick<LoadedParts, "measure">;
  readonly #host: EnteredSpacingHost;
  /** What this page has last kept on the device. Null: it has not changed it. */
  #written: { kept: UnitSpacing | undefined } | null = null;
  #changing: Promise<void> | null = null;

  constructor(
    viewer: Viewer,
    url: UrlState,
    parts: Pick<LoadedParts, "measure">,
    host: EnteredSpacingHost,
  ) {
    this.#viewer = viewer;
    this.#url = url;
    this.#parts = parts;
    this.#host = host;
  }

  /** Whether the volume is being opened with another spacing: camera, planes and measurements do not fit it yet. */
  get isChanging(): boolean {
    return this.#changing !== null;
  }

  /** Calls `action` after the present change. Returns false if there is none. */
  postpones(action: () => void): boolean {
    void this.#changing?.then(action);
    return this.isChanging;
  }

  /** Asks for the spacing. Camera, planes and measurements move along with the voxels. */
  async enter(): Promise<void> {
    const { info } = this.#viewer;
    if (!info) return;
    let askSpacing: typeof Ask;
    try {
      ({ askSpacing } = await import("../panel/spacing_dialog.ts"));
    } catch {
      this.#host.noDialog();
      return;
    }
    const answer = await askSpacing(this.#shown(info), info.isSpacingGiven === true);
    if (!answer || this.#viewer.info !== info) return;
    const entered = answer === "unknown" ? undefined : answer;
    const spacing = millimetres(entered);
    const isSame = info.isSpacingGiven && sameValue(spacing, info.spacing);
    if (!isSame) this.#host.rest();
    const isOwn = sameValue(keptLengths(info.contentId), info.spacing);
    const keep = () => {
      // What is removed may be a link's, and not the one that is kept.
      if (entered || isOwn) this.#keep(info, entered);
    };
    if (isSame) {
      keep();
      return;
    }
    const { camera } = this.#host;
    const { isWhole } = camera;
    await this.#change(info, spacing, keep, () => {
      this.#moveTo(spacing ?? info.statedSpacing ?? [1, 1, 1], info);
      return () => isWhole && camera.refit();
    });
  }

  /**
   * Restores the spacing and the camera of an earlier view, for undo and redo, and what was kept on the device then,
   * unless another page has changed it since. Returns false if the spacing has not changed.
   */
  restore({ spacing, keptSpacing: kept, camera }: SpacingView, failed: () => void): boolean {
    const { info } = this.#viewer;
    if (!info || !camera || sameValue(spacing, givenSpacing(info))) return false;
    const setCamera = () => this.#viewer.setCamera(camera);
    const keep = () => {
      const { contentId } = info;
      const isOurs = this.#written && sameValue(this.#written.kept, keptSpacing(contentId));
      if (isOurs) this.#keep(info, kept);
    };
    void this.#change(
      info,
      spacing,
      keep,
      () => {
        setCamera();
        return setCamera; // the other volume has other limits
      },
      failed,
    );
    return true;
  }

  /** The part of the page's state that undo and redo restore. */
  stateOf(info: StoreInfo): Pick<AddressState, "spacing" | "keptSpacing"> {
    return { spacing: givenSpacing(info), keptSpacing: keptSpacing(info.contentId) };
  }

  #keep({ contentId }: StoreInfo, kept: UnitSpacing | undefined): void {
    keepSpacing(contentId, kept);
    this.#written = { kept };
  }

  /** What the dialog shows first: what the visitor has entered, in its unit. */
  #shown({ contentId, spacing, isSpacingGiven }: StoreInfo): UnitSpacing {
    const kept = keptSpacing(contentId);
    if (isSpacingGiven && sameValue(millimetres(kept), spacing)) return kept ?? inUnit(spacing);
    return isSpacingGiven ? inUnit(spacing) : { lengths: spacing, unit: "mm" };
  }

  /**
   * `move`: changes the view before the volume is opened again. Returns what to do afterwards. `keep`: called when the
   * volume is open. `failed`: called if it could not be opened.
   */
  async #change(
    info: StoreInfo,
    spacing: Triple | undefined,
    keep: () => void,
    move: () => () => void,
    failed = () => {},
  ): Promise<void> {
    const before = givenSpacing(info);
    const { measures } = this.#url;
    const change = async () => {
      const finish = move();
      this.#choose(spacing);
      if (await this.#host.reopen()) {
        keep();
        finish();
      } else {
        this.#choose(before);
        if (measures) this.#url.measures = measures;
        failed();
        this.#host.failed();
      }
    };
    this.#changing = change().finally(() => {
      this.#changing = null;
      this.#host.changed();
    });
    await this.#changing;
  }

  #choose(spacing: Triple | undefined): void {
    this.#url.isSpacingChosen = true;
    if (spacing) this.#url.spacing = spacing;
    else delete this.#url.spacing;
  }

  #moveTo(spacing: Triple, info: StoreInfo): void {
    const viewer = this.#viewer;
    const change = respacing(info, spacing);
    const { clip, slices } = viewer;
    viewer.setClip({ ...clip, planes: clip.planes.map(change.plane) });
    if (slices.plane) viewer.setSlices({ ...slices, plane: change.plane(slices.plane) });
    if (viewer.camera) viewer.setCamera(change.camera(viewer.camera));
    const { measure } = this.#parts;
    if (measure) measure.respace(change);
    else if (this.#url.measures) {
      this.#url.measures = this.#url.measures.map((line) => {
        const measurement = readMeasurement(line);
        return measurement ? writeMeasurement(movedMeasurement(measurement, change)) : line;
      });
    }
  }
}
