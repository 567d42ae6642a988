"""A tracker's driver in thirty lines: pip install iceoryx2==0.10.0.

    python publish.py TOPIC [SECONDS] [ICEORYX2.toml]     as in /tracker/pencil/pose

Replace `reading()`. The layout is that of enact.Pose.1, see enact::wire::live::payload.
"""
import ctypes, math, os, sys, time
import iceoryx2 as iox2

class Pose(ctypes.Structure):
    _fields_ = [("sequence", ctypes.c_uint64), ("available_ns", ctypes.c_int64),
                ("sample_ns", ctypes.c_int64), ("device_ns", ctypes.c_int64),
                ("position_m", ctypes.c_double * 3), ("quaternion_xyzw", ctypes.c_double * 4),
                ("flags", ctypes.c_uint32), ("session", ctypes.c_uint32)]

    @staticmethod
    def type_name():
        return "enact.Pose.1"

def reading(time_s):  # position, orientation; None where sight is lost
    return (0.2 * math.cos(time_s), 0.2 * math.sin(time_s), 1.0), (0.0, 0.0, 0.0, 1.0)

def main(topic, seconds=10.0, config=None, rate_hz=200):
    builder = iox2.NodeBuilder.new().signal_handling_mode(iox2.SignalHandlingMode.Disabled)
    if config:
        builder = builder.config(iox2.config.from_file(iox2.FilePath.new(config)))
    service = (builder.create(iox2.ServiceType.Ipc)
               .service_builder(iox2.ServiceName.new("enact" + topic))
               .publish_subscribe(Pose).subscriber_max_buffer_size(2048).open_or_create())
    publisher = service.publisher_builder().create()
    session, begun = int.from_bytes(os.urandom(4), "little"), time.monotonic()
    for sequence in range(int(seconds * rate_hz)):
        time.sleep(max(0.0, begun + sequence / rate_hz - time.monotonic()))
        now_ns, pose = time.time_ns(), reading(sequence / rate_hz)
        position, orientation = pose or ((0.0,) * 3, (0.0, 0.0, 0.0, 1.0))
        publisher.send_copy(Pose(sequence, now_ns, now_ns, -2**63, position, orientation,
                                 1 if pose else 0, session))
    time.sleep(0.05)  # the daemon polls: what is sent last must be fetched before we leave

if __name__ == "__main__":
    main(sys.argv[1], float((sys.argv[2:3] or [10])[0]), *sys.argv[3:4])
