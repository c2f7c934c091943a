/**
 * Verifies AWS Signature Version 4 in the Authorization field of a request to S3, by the document
 * "Authenticating Requests: Using the Authorization Header" of AWS.
 */
import { createHash, createHmac } from "node:crypto";
import type { IncomingHttpHeaders } from "node:http";

export interface SignedRequest {
  method: string;
  /** The path with the parameters, as in the first line of the request. */
  target: string;
  headers: IncomingHttpHeaders;
  body: Uint8Array;
}

export interface Account {
  accessKey: string;
  secretKey: string;
  region: string;
  /** Of temporary credentials. */
  sessionToken?: string;
}

/** The code of S3's error; undefined if the request may pass. `now`: the server's clock (ms). */
export function signatureError(
  request: SignedRequest,
  account: Account,
  now: number,
): string | undefined {
  const { headers } = request;
  const parts =
    /^AWS4-HMAC-SHA256 Credential=([^/]+)\/(\d{8})\/([^/]+)\/s3\/aws4_request, ?SignedHeaders=([^,]+), ?Signature=([0-9a-f]{64})$/.exec(
      headers.authorization ?? "",
    );
  if (!parts) return headers.authorization ? "AuthorizationHeaderMalformed" : "AccessDenied";
  const [, accessKey = "", day = "", region = "", names = "", signature = ""] = parts;
  if (accessKey !== account.accessKey) return "InvalidAccessKeyId";
  if (region !== account.region) return "AuthorizationHeaderMalformed";
  const date = String(headers["x-amz-date"]);
  const [year, month, dayOfMonth, hour, minute, second] = [0, 4, 6, 9, 11, 13].map((at, i) =>
    Number(date.slice(at, at + (i === 0 ? 4 : 2))),
  ) as [number, number, number, number, number, number];
  const time = Date.UTC(year, month - 1, dayOfMonth, hour, minute, second);
  if (!date.startsWith(day) || !(Math.abs(now - time) < 15 * 60_000)) return "RequestTimeTooSkewed";
  const token = headers["x-amz-security-token"];
  if (token !== account.sessionToken) return token ? "InvalidToken" : "InvalidAccessKeyId";

  const signed = names.split(";");
  const required = ["host", ...Object.keys(headers).filter((name) => name.startsWith("x-amz-"))];
  if (!required.every((name) => signed.includes(name))) return "AccessDenied";
  const payload = String(headers["x-amz-content-sha256"]);
  if (payload !== "UNSIGNED-PAYLOAD" && payload !== sha256(request.body)) {
    return "XAmzContentSHA256Mismatch";
  }
  const [path = "", query = ""] = request.target.split("?");
  const canonical = [
    request.method,
    path.split("/").map(encoded).join("/"),
    query
      .split("&")
      .filter((pair) => pair !== "")
      .map((pair) => {
        const [name = "", value = ""] = pair.split("=");
        return `${encoded(name)}=${encoded(value)}`;
      })
      .sort()
      .join("&"),
    ...signed.map((name) => `${name}:${String(headers[name]).trim().replace(/ +/g, " ")}`),
    "",
    names,
    payload,
  ].join("\n");
  const scope = `${day}/${region}/s3/aws4_request`;
  const text = ["AWS4-HMAC-SHA256", date, scope, sha256(canonical)].join("\n");
  const key = [day, region, "s3", "aws4_request"].reduce<string | Buffer>(
    (secret, part) => createHmac("sha256", secret).update(part).digest(),
    `AWS4${account.secretKey}`,
  );
  const expected = createHmac("sha256", key).update(text).digest("hex");
  return expected === signature ? undefined : "SignatureDoesNotMatch";
}

function sha256(bytes: Uint8Array | string): string {
  return createHash("sha256").update(bytes).digest("hex");
}

/** Percent-encodes all but unreserved characters, after decoding. */
function encoded(text: string): string {
  return encodeURIComponent(decodeURIComponent(text)).replace(
    /[!'()*]/g,
    (c) => `%${c.charCodeAt(0).toString(16).toUpperCase()}`,
  );
}
