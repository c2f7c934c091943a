import "../shell/dialog_form.css";
import { html, nothing, render } from "lit";
import type { Triple } from "../../core/types.ts";
import { panelTexts } from "../../texts/panel.ts";
import { type SpacingUnit, spacingUnits, type UnitSpacing } from "../address/spacing_units.ts";
import { numberField } from "../shell/number_field.ts";

type Dialog = HTMLElement & { open: boolean };

/**
 * Asks for the distances between voxels. `shown`: those that the dialog shows first. `isEntered`: whether they can be
 * removed. Resolves to "unknown" if they are to be removed, and to undefined if the visitor cancels.
 */
export async function askSpacing(
  shown: UnitSpacing,
  isEntered: boolean,
): Promise<UnitSpacing | "unknown" | undefined> {
  await import("../shell/components.ts");
  let { lengths, unit } = shown;
  const holder = document.createElement("div");
  document.body.append(holder);
  return new Promise((resolve) => {
    let answer: UnitSpacing | "unknown" | undefined;
    // The dialog returns the focus while it closes.
    const end = (result: UnitSpacing | "unknown") => {
      answer = result;
      (holder.firstElementChild as Dialog).open = false;
    };
    const isValid = () => lengths.every((length) => length > 0 && Number.isFinite(length));
    const field = (axis: 0 | 1 | 2) =>
      numberField(panelTexts.spacingAlong("xyz".charAt(axis)), lengths[axis], (length) => {
        lengths = lengths.with(axis, length) as Triple;
        draw();
      });
    const draw = () => {
      render(
        html`<wa-dialog
          label=${panelTexts.spacing}
          open
          @wa-after-hide=${(event: Event) => {
            if (event.target !== holder.firstElementChild) return;
            holder.remove();
            resolve(answer);
          }}
        >
          <form
            class="dialog-form"
            @submit=${(event: Event) => {
              event.preventDefault();
              if (isValid()) end({ lengths, unit });
            }}
          >
            <p>${panelTexts.spacingText}</p>
            <div class="row">${field(0)} ${field(1)} ${field(2)}</div>
            <label>
              ${panelTexts.unit}
              <select
                @change=${(event: Event) => {
                  unit = (event.currentTarget as HTMLSelectElement).value as SpacingUnit;
                }}
              >
                ${spacingUnits.map(
                  (name) =>
                    html`<option value=${name} ?selected=${name === shown.unit}>${name}</option>`,
                )}
              </select>
            </label>
            ${isValid() ? nothing : html`<p role="status">${panelTexts.spacingAboveZero}</p>`}
            <wa-button type="submit" variant="brand" size="s" ?disabled=${!isValid()}
              >${panelTexts.useSpacing}</wa-button
            >
            ${
              isEntered
                ? html`<wa-button size="s" appearance="outlined" @click=${() => end("unknown")}
                    >${panelTexts.forgetSpacing}</wa-button
                  >`
                : nothing
            }
          </form>
        </wa-dialog>`,
        holder,
      );
    };
    draw();
    (holder.firstElementChild as Dialog).open = true;
  });
}
