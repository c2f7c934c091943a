import "./help.css";
import { html, render } from "lit";
import { helpTexts } from "../../texts/help.ts";

let dialog: (HTMLElement & { open: boolean }) | null = null;

export function showHelp(): void {
  if (!dialog) {
    const holder = document.createElement("div");
    document.body.append(holder);
    render(
      html`<wa-dialog label=${helpTexts.title} light-dismiss class="help">
        <!-- Arrow keys scroll the table while it has the focus. -->
        <table tabindex="0" aria-label=${helpTexts.title}>
          <tbody>
            ${helpTexts.rows.map(([keys, effect]) => html`<tr><th scope="row">${keys}</th><td>${effect}</td></tr>`)}
          </tbody>
        </table>
        <p class="quiet">${helpTexts.address}</p>
      </wa-dialog>`,
      holder,
    );
    dialog = holder.firstElementChild as typeof dialog;
  }
  if (dialog) dialog.open = true;
}
