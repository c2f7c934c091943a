import { firstKnown, type Language } from "../texts/languages.ts";

/**
 * The language of an element: that of its attribute `lang`, or of the nearest enclosing element
 * with one, in this document. English if there are no texts in that language.
 */
export function languageOf(element: Element): Language {
  for (let each: Element | null = element; each; each = parentOf(each)) {
    const lang = each.getAttribute("lang");
    if (lang) return firstKnown([lang]) ?? "en";
  }
  return "en";
}

/** The parent of an element. For a child of a shadow root, this is the host of the shadow tree. */
function parentOf(element: Element): Element | null {
  if (element.parentElement) return element.parentElement;
  const root = element.getRootNode();
  return root instanceof ShadowRoot ? root.host : null;
}
