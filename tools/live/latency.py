"""How long estimates take after the last mark: pip install iceoryx2==0.10.0.

    python latency.py SECONDS ICEORYX2.toml MARKS

Listens to marks and estimates while takes of MARKS marks each are acted, and says how long after
its last mark was sent each take's first estimate was received: median, 99 %, greatest [ms].
"""
import ctypes, sys, time
import iceoryx2 as iox2
from subscribe import Estimate, received, record, subscribe

U, I = ctypes.c_uint64, ctypes.c_int64
Mark = record("enact.Mark.1", ("sequence", U), ("available_ns", I), ("sample_ns", I), ("device_ns", I),
              ("event", ctypes.c_uint8 * 256), ("flags", ctypes.c_uint32), ("session", ctypes.c_uint32))

def main(seconds, config, count):
    builder = iox2.NodeBuilder.new().signal_handling_mode(iox2.SignalHandlingMode.Disabled)
    builder = builder.config(iox2.config.from_file(iox2.FilePath.new(config)))
    node = builder.create(iox2.ServiceType.Ipc)
    marks, estimates = (subscribe(node, "enact/" + name, payload, 256)
                        for name, payload in (("marks", Mark), ("estimate", Estimate)))
    sent, ready, end = [], {}, time.monotonic() + seconds
    while time.monotonic() < end:
        sent += [mark.available_ns for mark in received(marks)]
        for said in received(estimates):
            ready.setdefault(said.take, time.time_ns())
        time.sleep(0.0002)
    last = sent[count - 1::count]
    # The first take is number 1, and none is left out.
    after_ms = sorted((ready[take] - last[take - 1]) * 1e-6 for take in ready if take <= len(last))
    at = lambda share: after_ms[min(len(after_ms) - 1, int(share * len(after_ms)))]
    print(f"{len(after_ms)} takes: median {at(0.5):.2f}, 99 % {at(0.99):.2f}, greatest {after_ms[-1]:.2f} ms")

if __name__ == "__main__":
    main(float(sys.argv[1]), sys.argv[2], int(sys.argv[3]))
