import { takeSharedFiles } from "../offline/shared_files.ts";

/** The queue of the File Handling API, which exists if the page is an installed app. */
interface LaunchQueue {
  setConsumer(consumer: (launch: { files?: readonly FileSystemFileHandle[] }) => void): void;
}

/** Calls `take` with files that the system hands to the app: opened with it, or shared to it. */
export function onHandedOver(take: (files: readonly File[]) => void): void {
  const { launchQueue } = window as { launchQueue?: LaunchQueue };
  launchQueue?.setConsumer(async ({ files = [] }) => {
    if (files.length > 0) take(await Promise.all(files.map((file) => file.getFile())));
  });
  const { searchParams } = new URL(location.href);
  if (!searchParams.has("shared")) return;
  history.replaceState(null, "", location.pathname);
  void takeSharedFiles().then((files) => {
    if (files.length > 0) take(files);
  });
}
