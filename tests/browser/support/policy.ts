import type { Page } from "@playwright/test";

/** The refusals of the page's Content-Security-Policy so far, as the browser reports them. */
export function refusals(page: Page): readonly string[] {
  const found: string[] = [];
  page.on("console", (message) => {
    if (/Content Security Policy/i.test(message.text())) found.push(message.text());
  });
  return found;
}
