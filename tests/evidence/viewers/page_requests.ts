/**
 * The requests that the page itself makes when it is opened, recorded with Chromium in the proxy's
 * log.
 */
import { existsSync, readFileSync } from "node:fs";
import { chromium } from "@playwright/test";
import { launchOptions } from "../../browser/support/chromium.ts";
import type { PackagedNginx, ProxyLine } from "../../support/packaged_nginx.ts";
import type { RecordedRequest, RecordedVisit } from "./requests.ts";

/** The requests of the page's client, which are recorded separately. */
const ofClient =
  /^\/v1\/volumes\/[^/]+\/(bootstrap|[0-9a-f]{32}\/(header|pages|chunks|batch|file)\b)/;

/** Whether Chromium is installed. */
export const hasChromium = existsSync(launchOptions.executablePath);

/**
 * Opens a volume in a new browser, and waits until its controls are shown and no more requests are
 * made. `log`: the proxy's access log.
 */
export async function openPage(proxy: PackagedNginx, log: string, volume: string): Promise<void> {
  const { args } = launchOptions;
  const browser = await chromium.launch({
    ...launchOptions,
    args: [...args, ...proxy.chromiumArguments],
  });
  try {
    const page = await browser.newPage();
    await page.goto(`https://volumes.example:${proxy.port}/?volume=${volume}`);
    await page.waitForFunction(() => customElements.get("wa-slider") !== undefined);
    const lines = () => readFileSync(log, "utf8").length;
    for (let before = -1; before !== lines(); ) {
      before = lines();
      await new Promise((resolve) => setTimeout(resolve, 3000));
    }
  } finally {
    await browser.close();
  }
}

/**
 * The page's own requests in the lines of the proxy's log, and the time of the client's first
 * request (ms).
 */
export function pageRequests(lines: readonly ProxyLine[]): {
  requests: RecordedRequest[];
  clientBegins: number;
} {
  const begun = lines
    .map((line) => ({ ...line, begin: 1000 * (Number(line.end) - Number(line.seconds)) }))
    .sort((a, b) => a.begin - b.begin);
  const first = begun[0]?.begin ?? 0;
  const bootstrap = begun.find(({ target }) => target.includes("/bootstrap"));
  if (!bootstrap) throw new Error("the proxy's log: expected that the page opens a volume");
  const requests = begun
    .filter(({ target }) => !ofClient.test(target))
    .map(({ begin, target, range, encoding, bytes }) => ({
      at: begin - first,
      path: target,
      ...(range && { range }),
      ...(encoding && { encoding }),
      bytes: Number(bytes),
    }));
  return { requests, clientBegins: bootstrap.begin - first };
}

/**
 * A visit with the page's requests, and with the client's requests from the time at which the page
 * makes them.
 */
export function withPage(
  visit: RecordedVisit,
  { requests, clientBegins }: ReturnType<typeof pageRequests>,
): RecordedVisit {
  const later = visit.requests.map((request) => ({ ...request, at: request.at + clientBegins }));
  return {
    ...visit,
    requests: [...requests, ...later].sort((a, b) => a.at - b.at),
    duration: visit.duration + clientBegins,
  };
}
