/** A message above the page, without lit: it is shown where parts of the page may be missing. */
export interface PageNotice {
  role: "status" | "alert";
  text: string;
  /** In their order: the text of each, and what it does. */
  buttons: readonly (readonly [text: string, pressed: () => void])[];
}

/** Appends the message to the document, and returns it: its class is the caller's. */
export function showPageNotice({ role, text, buttons }: PageNotice): HTMLElement {
  const notice = document.createElement("section");
  notice.setAttribute("role", role);
  const paragraph = document.createElement("p");
  paragraph.textContent = text;
  notice.append(paragraph, ...buttons.map(([label, pressed]) => button(label, pressed)));
  document.body.append(notice);
  return notice;
}

function button(text: string, pressed: () => void): HTMLButtonElement {
  const element = document.createElement("button");
  element.type = "button";
  element.className = "chip";
  element.textContent = text;
  element.addEventListener("click", pressed);
  return element;
}
