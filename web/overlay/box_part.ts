import type { StoreInfo } from "../core/types.ts";
import { localized } from "../texts/numbers.ts";
import { boundingBox } from "./bounding_box.ts";
import type { Screen } from "./screen.ts";
import { svgElement } from "./shapes.ts";

/** The volume's box with ticks in millimetres, or in voxels, on three of its edges. */
export class BoxPart {
  readonly element = svgElement("svg", { class: "overlay-box", "aria-hidden": "true" });

  draw(info: StoreInfo, screen: Screen): void {
    const { edges, ticks } = boundingBox(info, screen) ?? { edges: [], ticks: [] };
    const lines = edges.map(({ from, to, isBehind }) =>
      svgElement("line", {
        x1: from.x,
        y1: from.y,
        x2: to.x,
        y2: to.y,
        ...(isBehind && { class: "behind" }),
      }),
    );
    const marks = ticks.flatMap(({ at, length, outwards: { x, y } }) => {
      const text = svgElement("text", {
        x: at.x + 9 * x,
        y: at.y + 11 * y,
        "text-anchor": Math.abs(x) < 0.4 ? "middle" : x < 0 ? "end" : "start",
        "dominant-baseline": "middle",
      });
      text.textContent = localized(String(Number(length.toPrecision(6))));
      return [svgElement("line", { x1: at.x, y1: at.y, x2: at.x + 5 * x, y2: at.y + 5 * y }), text];
    });
    this.element.replaceChildren(...lines, ...marks);
  }
}
