import { Core } from "./core";
import type { WorkerJob, WorkerResult, WorkerSetup } from "./decode_pool";
import { TileDecoder } from "./tile_decoder";

/** A decode worker: an instance of the core that answers each job with its result. */

const scope = self as unknown as {
  onmessage: ((event: MessageEvent<WorkerSetup | WorkerJob>) => void) | null;
  postMessage(message: WorkerResult, transfer: Transferable[]): void;
};

const images = new TileDecoder();
let core: Promise<Core> | null = null;

scope.onmessage = (event) => {
  if ("compiled" in event.data) {
    core = Core.create(event.data.compiled);
    return;
  }
  const { job } = event.data;
  decode(job).then(
    (result) => scope.postMessage({ result }, [result.buffer]),
    () => scope.postMessage({ result: null }, []),
  );
};

async function decode(job: Uint8Array): Promise<Uint8Array<ArrayBuffer>> {
  const it = await core;
  if (!it) throw new Error("a job came before the core");
  const image = it.withBytes(job, (pointer, size) =>
    it.module._lode_job_image(pointer, size) ? it.answer() : null,
  );
  if (image === null) {
    return it.withBytes(job, (pointer, size) => {
      it.module._lode_decode(pointer, size);
      return it.answer();
    });
  }
  const { rgba, width, height } = await images.decode(image);
  return it.withBytes(job, (pointer, size) =>
    it.withBytes(rgba, (texels) => {
      it.module._lode_decode_image(pointer, size, texels, width, height);
      return it.answer();
    }),
  );
}
