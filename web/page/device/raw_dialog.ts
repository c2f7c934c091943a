import "../shell/dialog_form.css";
import { html, render } from "lit";
import type { VoxelType } from "../../builder/types.ts";
import type { InputFile } from "../../device/files.ts";
import { guessRaw, type RawLayout, voxelBytes } from "../../device/raw_guess.ts";
import { layoutProblem } from "../../device/reading.ts";
import { deviceTexts } from "../../texts/device.ts";
import { formatBytes, formatType } from "../shell/format.ts";
import { numberField } from "../shell/number_field.ts";

type Dialog = HTMLElement & { open: boolean };

/**
 * Asks for the layout of the voxels in a raw file, beginning with a guess. Resolves to undefined if
 * the visitor cancels.
 */
export async function askRawLayout({ path, file }: InputFile): Promise<RawLayout | undefined> {
  await import("../shell/components.ts");
  let layout = guessRaw(path, file.size);
  const holder = document.createElement("div");
  document.body.append(holder);
  return new Promise((resolve) => {
    const end = (result: RawLayout | undefined) => {
      resolve(result);
      holder.remove();
    };
    const change = (part: Partial<RawLayout>) => {
      layout = { ...layout, ...part };
      draw();
    };
    const whole = { isWhole: true };
    const size = (axis: 0 | 1 | 2) => {
      const enter = (count: number) => {
        const dims: RawLayout["dims"] = [...layout.dims];
        dims[axis] = count;
        change({ dims });
      };
      return numberField(deviceTexts.along("xyz".charAt(axis)), layout.dims[axis], enter, whole);
    };
    const draw = () => {
      const problem = layoutProblem(layout, file.size);
      render(
        html`<wa-dialog
          label=${deviceTexts.raw}
          open
          @wa-after-hide=${(event: Event) => {
            if (event.target === holder.firstElementChild) end(undefined);
          }}
        >
          <form
            class="dialog-form"
            @submit=${(event: Event) => {
              event.preventDefault();
              if (!problem) end(layout);
            }}
          >
            <p>${deviceTexts.rawText(path, formatBytes(file.size))}</p>
            <div class="row">
              ${size(0)} ${size(1)} ${size(2)}
            </div>
            <label>
              ${deviceTexts.type}
              <select
                @change=${(event: Event) =>
                  change({ type: (event.currentTarget as HTMLSelectElement).value as VoxelType })}
              >
                ${Object.keys(voxelBytes).map(
                  (type) =>
                    html`<option value=${type} ?selected=${type === layout.type}>
                      ${formatType(type)}
                    </option>`,
                )}
              </select>
            </label>
            <label>
              ${deviceTexts.byteOrder}
              <select
                @change=${(event: Event) =>
                  change({ bigEndian: (event.currentTarget as HTMLSelectElement).value === "big" })}
              >
                <option value="little" ?selected=${!layout.bigEndian}>${deviceTexts.littleEndian}</option>
                <option value="big" ?selected=${layout.bigEndian}>${deviceTexts.bigEndian}</option>
              </select>
            </label>
            ${numberField(deviceTexts.skip, layout.skipBytes, (skipBytes) => change({ skipBytes }), whole)}
            <p role="status" class=${problem ? "" : "quiet"}>
              ${problem ?? deviceTexts.sizeFits}
            </p>
            <wa-button type="submit" variant="brand" size="s" ?disabled=${problem !== undefined}
              >${deviceTexts.build}</wa-button
            >
          </form>
        </wa-dialog>`,
        holder,
      );
    };
    draw();
    const dialog = holder.firstElementChild as Dialog;
    dialog.open = true;
  });
}
