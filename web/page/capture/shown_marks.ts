import { marksSvg } from "../../capture/picture_marks.ts";
import type { Measurement } from "../../measure/measurement.ts";
import { Screen } from "../../overlay/screen.ts";
import { panelTexts } from "../../texts/panel.ts";
import type { Camera, Legend, PictureSize } from "../../viewer/types.ts";
import type { Viewer } from "../../viewer/viewer.ts";
import { fieldNotes, legendTexts, listedLabels } from "../panel/legend.ts";

export const markNames = ["title", "scale", "axes", "legend", "measurements"] as const;
export type MarkName = (typeof markNames)[number];

/** The page whose picture is saved. */
export interface MarkedPage {
  viewer: Viewer;
  title(): string;
  /** With the texts beside them. */
  measurements(): readonly { measurement: Measurement; label: string }[];
}

/** The marks that a picture of the page can have. */
export function offeredMarks({ viewer, measurements }: MarkedPage): readonly MarkName[] {
  return markNames.filter((name) => {
    if (name === "legend") return viewer.legend !== null;
    return name !== "measurements" || measurements().length > 0;
  });
}

/** The lines of a legend of labels. */
function labelsOf(legend: Legend): { text: string; colour?: string }[] {
  const { labels, more } = listedLabels(legend);
  return more > 0 ? [...labels, { text: panelTexts.moreLabels(String(more)) }] : labels;
}

/** The marks as SVG (marksSvg); empty if there are none. `camera`: by default the present one. */
export function shownMarks(
  page: MarkedPage,
  chosen: ReadonlySet<MarkName>,
  size: PictureSize,
  isTransparent: boolean,
  camera: Camera | null = page.viewer.camera,
): string {
  const { viewer } = page;
  const { info, look, legend } = viewer;
  const names = offeredMarks(page).filter((name) => chosen.has(name));
  const matrix = camera && viewer.viewProjection(size.width, size.height, camera);
  if (names.length === 0 || !info || !matrix) return "";
  const texts = legend && legendTexts(legend, info.metadata.units);
  const has = (name: MarkName): boolean => names.includes(name);
  return marksSvg(
    {
      ...(has("title") && { title: page.title() }),
      ...(has("legend") &&
        legend &&
        texts && {
          legend: {
            name: texts.units ? `${texts.name} (${texts.units})` : texts.name,
            colours: legend.colours,
            ends: [texts.low, texts.high],
            ticks: legend.lines?.ticks ?? [],
            notes: fieldNotes(legend),
            ...(legend.categories && { labels: labelsOf(legend) }),
          },
        }),
      hasScale: has("scale"),
      hasAxes: has("axes"),
      ...(has("measurements") && { measurements: page.measurements() }),
    },
    {
      size,
      screen: new Screen(matrix, size.width, size.height),
      info,
      target: camera.target,
      background: isTransparent ? undefined : look.background,
    },
  );
}
