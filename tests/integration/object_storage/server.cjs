// Runs an S3 server on loopback until it is killed:
//   node server.cjs FOLDER PORT LATENCY_MS
// FOLDER keeps the bucket "stores". Each request is answered LATENCY_MS later. Prints {"listen": PORT}; for each request one JSON
// object with method, path and range (null without one); and when its response ends, one with sent_bytes (with the head).
// Exits with 77 if NODE_PATH has no s3rver: npm install s3rver@3.7.1
const fs = require('fs'), path = require('path');

const [folder, port, latency_ms] = process.argv.slice(2);
const found = (process.env.NODE_PATH || '').split(':').some((root) => root && fs.existsSync(path.join(root, 's3rver')));
if (!found) {
  console.error('NODE_PATH has no s3rver: npm install s3rver@3.7.1');
  process.exit(77);
}
const S3rver = require('s3rver');

const server = new S3rver({
  address: '127.0.0.1', port: Number(port), directory: folder, silent: true, configureBuckets: [{ name: 'stores' }],
});
server.middleware.unshift(async (ctx, next) => {
  const { socket } = ctx.req, before = socket.bytesWritten;
  console.log(JSON.stringify({ method: ctx.method, path: ctx.path, range: ctx.headers.range || null }));
  ctx.res.once('close', () => console.log(JSON.stringify({ sent_bytes: socket.bytesWritten - before })));
  await new Promise((resolve) => setTimeout(resolve, Number(latency_ms)));
  await next();
});
server.run().then((address) => console.log(JSON.stringify({ listen: address.port })));
