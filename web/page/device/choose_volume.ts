import "../shell/dialog_form.css";
import { html, nothing, render, type TemplateResult } from "lit";
import type { InputFile } from "../../device/files.ts";
import type { ReadableVolume } from "../../device/reading.ts";
import {
  formatOfName,
  unknownTextOf,
  type WrongContent,
  wrongContent,
} from "../../device/wrong_content.ts";
import { isBuildable, openZarrFolder, zarrFolderVolume } from "../../device/zarr_volume.ts";
import type { VolumeCandidate, VolumeChoice } from "../../import/types.ts";
import { deviceTexts } from "../../texts/device.ts";
import { pageTexts } from "../../texts/page.ts";
import { messageOf } from "../../texts/without_options.ts";
import type { ZarrImage, ZarrScale } from "../../zarr/types.ts";
import { formatBytes, formatDims } from "../shell/format.ts";

/** Maximum number of volumes to offer. The largest ones are offered. */
const mostOffered = 1000;

/**
 * Asks which of several volumes to open. Resolves to undefined if there are none, or if the visitor
 * cancels.
 */
export async function chooseVolume(
  volumes: readonly VolumeCandidate[],
): Promise<VolumeCandidate | undefined> {
  if (volumes.length < 2) return volumes[0];
  const text = ({ path, choice, name, format, bytes }: VolumeCandidate) => {
    const where = path === "." ? deviceTexts.theFiles : path;
    return `${where} · ${choice?.label ?? name ?? `${format} · ${formatBytes(bytes)}`}`;
  };
  const label = deviceTexts.whichVolume(volumes.length);
  return choose(label, volumes.slice(0, mostOffered), text);
}

/** Whether a volume is added to the picture, or replaces the open volume. */
export type Manner = "add" | "replace";

/**
 * Asks what to do with files while a volume is open. Resolves to undefined if the visitor cancels.
 */
export function chooseManner(): Promise<Manner | undefined> {
  const manners = ["add", "replace"] as const;
  return choose(deviceTexts.besideOpen, manners, (manner) => deviceTexts.manners[manner]);
}

/** Asks which of several volumes of a file to read: see Chooser. */
export async function chooseInFile(
  choices: readonly VolumeChoice[],
  problem: Error | undefined,
): Promise<VolumeChoice | undefined> {
  const [first] = choices;
  if (!first) return undefined;
  const kind = kindOf(first);
  const text = (choice: VolumeChoice) => choiceText(choice, kind);
  if (kind !== "allow" || !problem) return choose(deviceTexts.which[kind], choices, text);
  const what = deviceTexts.faulty[first.options.allow?.[0] ?? "gaps"];
  const accepted = await choose(deviceTexts.which.allow, choices, text, {
    what,
    detail: messageOf(problem),
  });
  if (!accepted) throw problem;
  return accepted;
}

type ChoiceKind = keyof VolumeChoice["options"];

const kinds = ["allow", "segment", "channel", "timeStep", "dataset", "series"] as const;

/** The kind of option that a choice sets. */
function kindOf({ options }: VolumeChoice): ChoiceKind {
  return kinds.find((kind) => options[kind] !== undefined) ?? "series";
}

function choiceText({ name = "", options }: VolumeChoice, kind: ChoiceKind): string {
  if (kind === "allow") return deviceTexts.allow[options.allow?.[0] ?? "gaps"];
  if (kind === "dataset") return name || `${options.dataset}`;
  const numbered = deviceTexts.numbered[kind](`${options[kind]}`);
  return name && name !== options[kind] ? `${numbered} · ${name}` : numbered;
}

/**
 * Asks which scale of an image to open, unless its URL names one. Resolves to undefined if the
 * visitor cancels. Rejects if the browser can build none of them.
 */
export async function chooseScale({
  scales: all,
  chosen,
}: ZarrImage): Promise<ZarrScale | undefined> {
  const bySize = all
    .filter((_, i) => chosen === undefined || i === chosen)
    .sort((a, b) => b.voxelBytes - a.voxelBytes);
  const scales = bySize.filter(isBuildable);
  const smallest = bySize.at(-1);
  if (scales.length === 0 && smallest) {
    const { description, voxelBytes } = smallest;
    throw new Error(deviceTexts.noScale(description.name, formatBytes(voxelBytes)));
  }
  if (bySize.length === 1) return scales[0];
  const left = bySize.length - scales.length;
  const text = ({ description, voxelBytes }: ZarrScale) =>
    deviceTexts.scale(formatDims(description.voxels), formatBytes(voxelBytes));
  const tooLarge = left > 0 ? ` ${deviceTexts.tooLarge(left)}` : "";
  return choose(deviceTexts.whichScale + tooLarge, scales, text);
}

/**
 * Asks which scale of a Zarr hierarchy in a folder of files to open. Resolves to undefined if the
 * visitor cancels. Rejects like `openZarrFolder` and `chooseScale`.
 */
export async function chooseInZarr(
  folder: string,
  files: readonly InputFile[],
  signal: AbortSignal,
): Promise<ReadableVolume | undefined> {
  const image = await openZarrFolder(folder, files, signal);
  const scale = await chooseScale(image);
  return scale && zarrFolderVolume(image, scale, files);
}

/**
 * Rejects if no volume was found among the files. Resolves to a single file, unless it is empty or a web page:
 * the error of opening it says more (`rejectOpening`).
 */
export async function nothingFound(
  files: readonly InputFile[],
): Promise<Pick<VolumeCandidate, "path" | "choice" | "needsDims">> {
  const [first] = files;
  if (first && files.length === 1) {
    const content = await wrongContent(first.file);
    if (!content || content.kind === "text") return { path: first.path, needsDims: false };
    throw wrongContentError(first.path, content);
  }
  const names = files
    .slice(0, 3)
    .map(({ path }) => path)
    .join(", ");
  const found =
    files.length === 0
      ? deviceTexts.noFiles
      : `${deviceTexts.files(files.length)}: ${names}${files.length > 3 ? ", …" : ""}`;
  throw new Error(deviceTexts.nothingFound(found));
}

/**
 * Rejects with the error of opening a file, or with one in the page's language if the file is a text of no
 * known kind.
 */
export async function rejectOpening(
  error: unknown,
  files: readonly InputFile[],
  path: string,
): Promise<never> {
  const file = files.find((each) => each.path === path)?.file;
  const content = file && (await unknownTextOf(error, file));
  throw content ? wrongContentError(path, content) : error;
}

function wrongContentError(path: string, content: WrongContent): Error {
  const found =
    content.kind === "text"
      ? deviceTexts.contents.text(content.beginning)
      : deviceTexts.contents[content.kind];
  const format = formatOfName(path);
  return new Error(
    format === undefined
      ? deviceTexts.nothingFound(`${path}: ${found}`)
      : deviceTexts.wrongContent(path, format, found),
  );
}

/** More choices than this are offered in a drop-down list instead of buttons. */
const mostButtons = 12;

/** The reason for asking. `detail`: what was expected and found, in English. */
interface Reason {
  what: string;
  detail: string;
}

/**
 * Asks for one of several choices. `problem`: the reason for asking. Resolves to undefined if the
 * visitor cancels.
 */
async function choose<T>(
  label: string,
  offered: readonly T[],
  text: (each: T) => string,
  problem?: Reason,
): Promise<T | undefined> {
  await import("../shell/components.ts");
  const holder = document.createElement("div");
  document.body.append(holder);
  return new Promise((resolve) => {
    const end = (chosen: T | undefined) => {
      resolve(chosen);
      holder.remove();
    };
    render(
      html`<wa-dialog
        label=${label}
        open
        @wa-after-hide=${(event: Event) => {
          if (event.target === holder.firstElementChild) end(undefined);
        }}
      >
        ${offered.length > mostButtons ? list(label, offered, text, end) : buttons(offered, text, end, problem)}
      </wa-dialog>`,
      holder,
    );
  });
}

function buttons<T>(
  offered: readonly T[],
  text: (each: T) => string,
  end: (chosen: T) => void,
  problem: Reason | undefined,
): TemplateResult {
  return html`<div class="dialog-form">
    ${problem ? html`<p>${problem.what}</p>${details(problem.detail)}` : nothing}
    ${offered.map(
      (each) =>
        html`<wa-button appearance="outlined" size="s" @click=${() => end(each)}
          >${text(each)}</wa-button
        >`,
    )}
  </div>`;
}

function details(detail: string): TemplateResult {
  return html`<details class="problem-detail">
    <summary>${pageTexts.details}</summary>
    <code>${detail}</code>
  </details>`;
}

function list<T>(
  label: string,
  offered: readonly T[],
  text: (each: T) => string,
  end: (chosen: T | undefined) => void,
): TemplateResult {
  const submit = (event: Event) => {
    event.preventDefault();
    const form = event.currentTarget as HTMLFormElement;
    end(offered[form.querySelector("select")?.selectedIndex ?? 0]);
  };
  return html`<form class="dialog-form" @submit=${submit}>
    <select aria-label=${label} autofocus>
      ${offered.map((each) => html`<option>${text(each)}</option>`)}
    </select>
    <wa-button type="submit" variant="brand" size="s">${deviceTexts.build}</wa-button>
  </form>`;
}
