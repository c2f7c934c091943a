/**
 * Makes the page, and the data fetched with it, available without a network. Everything comes from the
 * network as long as it responds, except files that never change.
 */
import { type PageBuild, PageCache } from "./page_cache.ts";
import { answerKind, keepAnswer, keptAnswer } from "./seen_answers.ts";
import { keepSharedFiles } from "./shared_files.ts";

declare const self: ServiceWorkerGlobalScope;
/** Inserted by the build (vite.config.ts). */
declare const pageBuild: PageBuild;

const base = self.registration.scope;
const page = new PageCache(pageBuild, base);

self.addEventListener("install", (event) => event.waitUntil(page.install()));

self.addEventListener("activate", (event) => {
  const preload = self.registration.navigationPreload?.enable();
  event.waitUntil(Promise.all([page.removeOld(), preload, self.clients.claim()]));
});

self.addEventListener("message", ({ data }) => {
  if (data === "replace") void self.skipWaiting();
});

self.addEventListener("fetch", (event) => {
  const { request } = event;
  const url = new URL(request.url);
  if (!url.href.startsWith(base)) return;
  const path = url.href.slice(base.length).replace(/[?#].*$/s, "");
  if (request.method === "POST" && path === "share") {
    event.respondWith(shared(request));
    return;
  }
  if (request.method !== "GET") return;
  if (page.isFile(path)) {
    event.respondWith(page.answer(path, request, event.preloadResponse));
    return;
  }
  const kind = answerKind(path, url.search);
  if (kind) event.respondWith(answerOf(kind, request, (kept) => event.waitUntil(kept)));
});

/** Responds from the network, and keeps the response; without a network, responds with the kept one. */
async function answerOf(
  kind: NonNullable<ReturnType<typeof answerKind>>,
  request: Request,
  wait: (kept: Promise<void>) => void,
): Promise<Response> {
  try {
    const answer = await fetch(request);
    wait(keepAnswer(kind, request, answer.clone()));
    return answer;
  } catch (error) {
    if (request.signal.aborted) throw error;
    const kept = await keptAnswer(kind, request);
    if (!kept) throw error;
    return kept;
  }
}

async function shared(request: Request): Promise<Response> {
  await keepSharedFiles(request);
  return Response.redirect(`${base}?shared`, 303);
}
