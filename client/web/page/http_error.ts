/** An HTTP status that the page explains. */
export class HttpError extends Error {
  constructor(readonly status: number) {
    super(`HTTP status ${status}`);
  }

  get wantsToken(): boolean {
    return this.status === 401 || this.status === 403;
  }
}
