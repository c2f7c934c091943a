/** nginx in front of a server, with the configuration that the packages have. */
import { type ChildProcess, spawn, spawnSync } from "node:child_process";
import { once } from "node:events";
import { mkdirSync, readFileSync, writeFileSync } from "node:fs";
import { type ClientHttp2Session, connect } from "node:http2";
import { join } from "node:path";
import { fileURLToPath } from "node:url";
import { type CertificateFiles, chromiumArgumentsFor, makeCertificate } from "./certificate.ts";
import { freePort, hasNginx } from "./nginx.ts";

const root = fileURLToPath(new URL("../..", import.meta.url));

/** Whether nginx is installed, and openssl, which makes its certificate. */
export const hasPackagedNginx = hasNginx && spawnSync("openssl", ["version"]).error === undefined;

export interface PackagedNginxOptions {
  /** Uses the configuration for several servers, with these ports. Default: the one for a single server. */
  cluster?: readonly [string, string, string];
  /** Maximum size of the cache, in nginx's notation. Default: that of the packages. */
  cacheSize?: string;
  /** A file to which a line of JSON is written for each request: see ProxyLine. */
  accessLog?: string;
}

/** A line of `PackagedNginxOptions.accessLog`. */
export interface ProxyLine {
  /** When the response had been sent, in seconds since 1970, and how long that took. */
  end: string;
  seconds: string;
  target: string;
  range: string;
  encoding: string;
  /** Bytes of the body. */
  bytes: string;
}

export interface PackagedNginx {
  port: number;
  /** The certificate of volumes.example, in PEM. */
  certificate: Buffer;
  cacheFolder: string;
  /** Arguments that make Chromium accept this certificate, and find volumes.example here. */
  chromiumArguments: string[];
  stop(): Promise<void>;
}

/**
 * Connects to volumes.example by HTTP/2. Rejects if that fails. `from`: the client's address.
 * `port`: the port of the proxy, or of another proxy in front of it.
 */
export async function connectToProxy(
  { certificate, port }: Pick<PackagedNginx, "certificate" | "port">,
  from?: string,
): Promise<ClientHttp2Session> {
  const session = connect(`https://volumes.example:${port}`, {
    lookup: (_name, { all }, found) =>
      all ? found(null, [{ address: "127.0.0.1", family: 4 }]) : found(null, "127.0.0.1", 4),
    ca: certificate,
    ...(from && { localAddress: from }),
  });
  await once(session, "connect");
  return session;
}

/** Starts nginx for volumes.example in front of a server. `folder`: for nginx's files. */
export async function startPackagedNginx(
  folder: string,
  serverPort: number | string,
  options: PackagedNginxOptions = {},
): Promise<PackagedNginx> {
  const port = await freePort();
  const files = makeCertificate(folder, "volumes.example");
  const cacheFolder = join(folder, "cache");
  mkdirSync(cacheFolder);
  const [errors, file] = [join(folder, "errors"), join(folder, "nginx.conf")];
  writeFileSync(errors, "");
  writeFileSync(file, configuration(folder, files, port, serverPort, options));
  const proxy = spawn("/usr/sbin/nginx", ["-p", folder, "-c", file, "-e", errors], {
    stdio: "ignore",
  });
  // Ends nginx if the test process ends before stop().
  const kill = () => void proxy.kill("SIGTERM");
  process.once("exit", kill);
  proxy.once("exit", () => process.off("exit", kill));
  const secured = { port, certificate: readFileSync(files.certificate) };
  for (let attempt = 0; ; ++attempt) {
    const session = await connectToProxy(secured).catch(() => undefined);
    if (session) {
      session.destroy();
      break;
    }
    if (attempt === 200 || proxy.exitCode !== null) {
      await stop(proxy);
      throw new Error(`nginx did not start: ${readFileSync(errors, "utf8")}`);
    }
    await new Promise((next) => setTimeout(next, 50));
  }
  return {
    ...secured,
    cacheFolder,
    chromiumArguments: chromiumArgumentsFor(secured.certificate, "volumes.example"),
    stop: () => stop(proxy),
  };
}

/** The configuration of the packages; only paths, ports and the values of `options` differ. */
function configuration(
  folder: string,
  { certificate, key }: CertificateFiles,
  port: number,
  serverPort: number | string,
  { cacheSize, accessLog, cluster }: PackagedNginxOptions,
): string {
  const name = cluster ? "nginx-cluster.conf" : "nginx.conf";
  const replaced = (text: string, from: string, to: string): string => {
    if (!text.includes(from)) throw new Error(`native/packaging/${name}: expected "${from}"`);
    return text.replaceAll(from, to);
  };
  let site = readFileSync(join(root, "native/packaging", name), "utf8");
  for (const [from, to] of [
    ...(cluster?.map((at, i) => [`10.0.0.1${i + 1}:8080 `, `127.0.0.1:${at} `] as const) ?? [
      ["/var/cache/nginx/isosplat", join(folder, "cache")],
      ["127.0.0.1:8080", `127.0.0.1:${serverPort}`],
    ]),
    ["/etc/ssl/volumes.example.pem", certificate],
    ["/etc/ssl/volumes.example.key", key],
    ["listen 443 ", `listen 127.0.0.1:${port} `],
    ...(cacheSize ? [["max_size=10g", `max_size=${cacheSize}`] as const] : []),
  ] as const) {
    site = replaced(site, from, to);
  }
  const user = process.getuid?.() === 0 ? "user root;" : "";
  const format = `log_format lines escape=json '{"end":"$msec","seconds":"$request_time",'
    '"target":"$request_uri","range":"$http_range","encoding":"$http_accept_encoding",'
    '"bytes":"$body_bytes_sent"}';`;
  return `daemon off; ${user} worker_processes auto; pid ${folder}/pid; error_log ${folder}/errors;
    events { worker_connections 8192; }
    http {
      ${format}
      access_log ${accessLog ? `${accessLog} lines` : "off"};
      client_body_temp_path ${folder}/1; proxy_temp_path ${folder}/2; fastcgi_temp_path ${folder}/3;
      uwsgi_temp_path ${folder}/4; scgi_temp_path ${folder}/5;
      ${site}
    }`;
}

async function stop(proxy: ChildProcess): Promise<void> {
  if (proxy.exitCode !== null) return;
  proxy.kill("SIGTERM");
  await once(proxy, "exit");
}
