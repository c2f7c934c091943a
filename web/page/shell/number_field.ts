import { html, type TemplateResult } from "lit";
import { localized } from "../../texts/numbers.ts";
import { parseValue } from "./format.ts";

/**
 * A labelled field for a number, with a decimal point or a decimal comma in every language. A field of type "number"
 * would follow the browser's language: with a decimal point, it reads 0,25 as 25. `value`: shown until the visitor
 * types. `change`: called with NaN if the text is not a number.
 */
export function numberField(
  label: string,
  value: number,
  change: (value: number) => void,
  { isWhole = false }: { isWhole?: boolean } = {},
): TemplateResult {
  // The attribute is the first text only: the property would replace the text while the visitor types "1,".
  return html`<label>
    ${label}
    <input
      type="text"
      inputmode=${isWhole ? "numeric" : "decimal"}
      autocomplete="off"
      value=${Number.isNaN(value) ? "" : localized(String(value))}
      @input=${(event: Event) =>
        change(parseValue((event.currentTarget as HTMLInputElement).value) ?? Number.NaN)}
    />
  </label>`;
}
