import "../shell/dialog_form.css";
import { html, nothing, render } from "lit";
import type { StoreInfo, Triple } from "../../core/types.ts";
import { panelTexts } from "../../texts/panel.ts";

type Dialog = HTMLElement & { open: boolean };

/** Units that can be entered, in millimetres. */
const units = { mm: 1, µm: 1e-3, nm: 1e-6, Å: 1e-7, cm: 10, m: 1000 };
type Unit = keyof typeof units;

/** Asks for the distances between voxels (mm). Resolves to undefined if the visitor cancels. */
export async function askSpacing(info: StoreInfo): Promise<Triple | undefined> {
  await import("../shell/components.ts");
  let lengths: Triple = [...info.spacing];
  let unit: Unit = "mm";
  const holder = document.createElement("div");
  document.body.append(holder);
  return new Promise((resolve) => {
    const end = (result: Triple | undefined) => {
      resolve(result);
      holder.remove();
    };
    const isValid = () => lengths.every((length) => length > 0 && Number.isFinite(length));
    const field = (axis: 0 | 1 | 2) => html`<label>
      ${panelTexts.spacingAlong("xyz".charAt(axis))}
      <input
        type="number"
        min="0"
        step="any"
        required
        inputmode="decimal"
        .value=${String(lengths[axis])}
        @input=${(event: Event) => {
          const changed: Triple = [...lengths];
          changed[axis] = (event.currentTarget as HTMLInputElement).valueAsNumber;
          lengths = changed;
          draw();
        }}
      />
    </label>`;
    const draw = () => {
      render(
        html`<wa-dialog
          label=${panelTexts.spacing}
          open
          @wa-after-hide=${(event: Event) => {
            if (event.target === holder.firstElementChild) end(undefined);
          }}
        >
          <form
            class="dialog-form"
            @submit=${(event: Event) => {
              event.preventDefault();
              if (isValid()) end(lengths.map((length) => length * units[unit]) as Triple);
            }}
          >
            <p>${panelTexts.spacingText}</p>
            <div class="row">${field(0)} ${field(1)} ${field(2)}</div>
            <label>
              ${panelTexts.unit}
              <select
                @change=${(event: Event) => {
                  unit = (event.currentTarget as HTMLSelectElement).value as Unit;
                }}
              >
                ${Object.keys(units).map((name) => html`<option value=${name}>${name}</option>`)}
              </select>
            </label>
            ${isValid() ? nothing : html`<p role="status">${panelTexts.spacingAboveZero}</p>`}
            <wa-button type="submit" variant="brand" size="s" ?disabled=${!isValid()}
              >${panelTexts.useSpacing}</wa-button
            >
          </form>
        </wa-dialog>`,
        holder,
      );
    };
    draw();
    (holder.firstElementChild as Dialog).open = true;
  });
}
