#!/bin/sh
# What a machine that loses its power keeps of a take: the daemon writes to a file system in a file,
# which is copied at random moments, as the disk has it then, and mounted again.
#
#     tools/live/power_loss.sh [TIMES]
#
# Needs root for loop mounts, mkfs.ext4, and the Python clients that `../check_live.sh` installs. Says,
# time by time, how old the last sample saved was when the power went [ms]; the daemon stands still
# while the copy is made.
set -eu
times=${1:-20}
cd "$(dirname "$0")/../.."
root=$PWD
cargo build -q --release --workspace --bin enact --bin tracker
enact=$root/target/release/enact
made=$(mktemp -d)
daemon=
finish() {
    [ -z "$daemon" ] || { kill -CONT "$daemon" && kill -KILL "$daemon"; } 2>/dev/null || true
    umount "$made/disk" "$made/after" 2>/dev/null || true
    rm -rf "$made" /dev/shm/enact_power_$$_*
}
trap finish EXIT
cd "$made"
printf '[global]\nroot-path = "%s/iceoryx2/"\nprefix = "enact_power_%s_"\n' "$made" $$ >iceoryx2.toml
mkdir disk after
truncate -s 64M disk.img
mkfs.ext4 -q disk.img
mount -o loop disk.img disk

for _ in $(seq "$times"); do
    : >said.txt
    "$enact" capture "$root/config/pencil_tip.toml" -o disk/takes --start --iceoryx2 iceoryx2.toml \
        --format ndjson >said.txt &
    daemon=$!
    until grep -q '"started"' said.txt; do sleep 0.05; done
    "$root/target/release/tracker" --load 1 --names pencil --rate-hz 1000 --seconds 6 --wait 1 \
        --iceoryx2 iceoryx2.toml >/dev/null 2>&1 &
    tracker=$!
    sleep "$(awk 'BEGIN { srand(); print 2.5 + 3 * rand() }')"
    kill -STOP $daemon
    stopped_ns=$(date +%s%N)
    cp disk.img after.img
    kill -KILL $daemon
    wait $daemon 2>/dev/null || true
    daemon=
    wait $tracker || true
    mount -o loop after.img after
    "$enact" recover after/takes >/dev/null || true
    "$root/target/clients/bin/python" - "$stopped_ns" after/takes/*.mcap <<'END'
import struct, sys
from mcap.reader import make_reader
stopped_ns, path = int(sys.argv[1]), sys.argv[-1]
with open(path, "rb") as file:
    raw = [m for _, c, m in make_reader(file).iter_messages() if c.topic.startswith("/capture/tracker")]
# A raw pose begins with its sequence number, after the header of its encoding.
numbers = [struct.unpack_from("<Q", m.data, 4)[0] for m in raw]
missing = numbers[-1] - numbers[0] + 1 - len(numbers)
print(f"{(stopped_ns - raw[-1].log_time) * 1e-6:.0f} ms; before it {len(raw)} samples, {missing} missing")
END
    umount after
    rm -rf disk/takes
done
