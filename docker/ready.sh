#!/bin/bash
# Health check: succeeds if /readyz of the server in this container answers 200. Needs no HTTP client.
exec 3<>"/dev/tcp/127.0.0.1/${LODESTREAM_METRICS_PORT:-9400}" || exit 1
printf 'GET /readyz HTTP/1.0\r\n\r\n' >&3
read -r -t 2 _ status _ <&3
[[ "$status" == 200 ]]
