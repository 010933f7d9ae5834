#!/bin/bash
# Whether the server in this container is ready, as /readyz says: for a health check, without a program to ask HTTP with.
exec 3<>"/dev/tcp/127.0.0.1/${LODESTREAM_METRICS_PORT:-9400}" || exit 1
printf 'GET /readyz HTTP/1.0\r\n\r\n' >&3
read -r -t 2 _ status _ <&3
[[ "$status" == 200 ]]
