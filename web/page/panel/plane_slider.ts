import { html, type TemplateResult } from "lit";
import type { StoreInfo } from "../../core/types.ts";
import { extentAlong } from "../../viewer/clipping.ts";
import type { ClipPlane } from "../../viewer/types.ts";
import { type ValueElement, withValue } from "./form_elements.ts";

/**
 * A slider that moves a plane along its normal through the volume. `formatter` makes the text for a
 * position, which is a fraction of the volume's extent (0 … 1).
 */
export function planeSlider(
  label: string,
  { normal, offset }: ClipPlane,
  info: StoreInfo,
  formatter: (share: number) => string,
  move: (offset: number) => void,
): TemplateResult {
  const [low, high] = extentAlong(normal, info);
  const input = (event: Event) => {
    const share = Number((event.currentTarget as ValueElement).value);
    move(low + share * (high - low));
  };
  const share = (offset - low) / (high - low);
  return withValue(
    html`<wa-slider
      size="s"
      label=${label}
      min="0"
      max="1"
      step="0.005"
      .value=${share}
      .valueFormatter=${formatter}
      @input=${input}
    ></wa-slider>`,
    formatter(share),
  );
}
