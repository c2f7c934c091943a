import type { Page } from "@playwright/test";

/** What the page's Content-Security-Policy has refused so far, as the browser reports it. */
export function refusals(page: Page): readonly string[] {
  const found: string[] = [];
  page.on("console", (message) => {
    if (/Content Security Policy/i.test(message.text())) found.push(message.text());
  });
  return found;
}
