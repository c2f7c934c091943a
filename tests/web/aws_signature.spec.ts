/** The verifier of the tests' S3 service, with the examples of AWS's document. */
import { expect, test } from "vitest";
import { signatureError } from "../support/aws_signature.ts";

const account = {
  accessKey: "AKIAIOSFODNN7EXAMPLE",
  secretKey: "wJalrXUtnFEMI/K7MDENG/bPxRfiCYEXAMPLEKEY",
  region: "us-east-1",
};
const empty = "e3b0c44298fc1c149afbf4c8996fb92427ae41e4649b934ca495991b7852b855";
const now = Date.UTC(2013, 4, 24, 0, 5);
const getRange = {
  method: "GET",
  target: "/test.txt",
  headers: {
    host: "examplebucket.s3.amazonaws.com",
    range: "bytes=0-9",
    "x-amz-content-sha256": empty,
    "x-amz-date": "20130524T000000Z",
    authorization:
      "AWS4-HMAC-SHA256 Credential=AKIAIOSFODNN7EXAMPLE/20130524/us-east-1/s3/aws4_request," +
      "SignedHeaders=host;range;x-amz-content-sha256;x-amz-date," +
      "Signature=f0e8bdb87c964420e857bd35b5d6ed310bd44f0170aba48dd91039c6036bdb41",
  },
  body: new Uint8Array(),
};
const listBucket = {
  ...getRange,
  target: "/?max-keys=2&prefix=J",
  headers: {
    host: "examplebucket.s3.amazonaws.com",
    "x-amz-content-sha256": empty,
    "x-amz-date": "20130524T000000Z",
    authorization:
      "AWS4-HMAC-SHA256 Credential=AKIAIOSFODNN7EXAMPLE/20130524/us-east-1/s3/aws4_request," +
      "SignedHeaders=host;x-amz-content-sha256;x-amz-date," +
      "Signature=34b48302e7b5fa45bde8084f4b7868a86f0a534bc59db6670ed5711ef69dc6f7",
  },
};

test("the signatures of AWS's examples are valid", () => {
  expect(signatureError(getRange, account, now)).toBeUndefined();
  expect(signatureError(listBucket, account, now)).toBeUndefined();
});

test("another path, body, secret, clock or field is refused", () => {
  const refusal = (change: object, by = account, at = now) =>
    signatureError({ ...getRange, ...change }, by, at);
  expect(refusal({ target: "/test.txt?a=b" })).toBe("SignatureDoesNotMatch");
  expect(refusal({ body: Buffer.from("x") })).toBe("XAmzContentSHA256Mismatch");
  expect(refusal({}, { ...account, secretKey: "x" })).toBe("SignatureDoesNotMatch");
  expect(refusal({}, account, now + 3_600_000)).toBe("RequestTimeTooSkewed");
  expect(refusal({ headers: { ...getRange.headers, "x-amz-acl": "public-read" } })).toBe(
    "AccessDenied",
  );
  expect(refusal({ headers: {} })).toBe("AccessDenied");
});
