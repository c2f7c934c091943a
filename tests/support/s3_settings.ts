/** Settings of S3 for the program in tests. */
import { account } from "./s3_service.ts";

/** No settings of the person who runs the tests. */
export const nobody = {
  AWS_ACCESS_KEY_ID: undefined,
  AWS_SECRET_ACCESS_KEY: undefined,
  AWS_SESSION_TOKEN: undefined,
  AWS_REGION: undefined,
  AWS_DEFAULT_REGION: undefined,
  AWS_PROFILE: undefined,
  AWS_ENDPOINT_URL: undefined,
  AWS_ENDPOINT_URL_S3: undefined,
  AWS_SHARED_CREDENTIALS_FILE: "/nonexistent",
  AWS_CONFIG_FILE: "/nonexistent",
};

/** Those of the service's account. */
export const person = {
  ...nobody,
  AWS_ACCESS_KEY_ID: account.accessKey,
  AWS_SECRET_ACCESS_KEY: account.secretKey,
  AWS_REGION: account.region,
};
