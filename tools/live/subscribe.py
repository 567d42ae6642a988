"""Hears estimates, one JSON object per line: pip install iceoryx2==0.10.0.

    python subscribe.py [SECONDS] [ICEORYX2.toml] [BODY...]

Ends after SECONDS. Of the frames of BODY it says how many came with each estimate.
"""
import ctypes, json, sys, time
import iceoryx2 as iox2

def record(name, *fields):
    return type(name, (ctypes.Structure,), {
        "_fields_": list(fields), "type_name": staticmethod(lambda: name)})

U, I, D = ctypes.c_uint64, ctypes.c_int64, ctypes.c_double
Estimate = record("enact.Estimate.1", ("sequence", U), ("available_ns", I), ("take", U), ("marks", U),
                  ("origin_ns", I), ("frames", U), ("objective", D), ("physical_s", D),
                  ("residual_m", D), ("residual_rad", D), ("iterations", U),
                  ("verdict", ctypes.c_uint32), ("is_final", ctypes.c_uint32))
Frame = record("enact.EstimatedPose.1", ("estimate", U), ("take", U), ("index", U), ("count", U),
               ("sample_ns", I), ("position_m", D * 3), ("quaternion_xyzw", D * 4))

def subscribe(node, name, payload, buffer):
    service = (node.service_builder(iox2.ServiceName.new(name)).publish_subscribe(payload)
               .subscriber_max_buffer_size(buffer).open_or_create())
    return service.subscriber_builder().buffer_size(buffer).create()

def received(subscriber):
    while (sample := subscriber.receive()) is not None:
        yield sample.payload().contents

def main(seconds=10.0, config=None, *bodies):
    builder = iox2.NodeBuilder.new().signal_handling_mode(iox2.SignalHandlingMode.Disabled)
    if config:
        builder = builder.config(iox2.config.from_file(iox2.FilePath.new(config)))
    node = builder.create(iox2.ServiceType.Ipc)
    estimates = subscribe(node, "enact/estimate", Estimate, 256)
    frames = {body: subscribe(node, f"enact/estimate/{body}/pose", Frame, 4096) for body in bodies}
    end = time.monotonic() + seconds
    while time.monotonic() < end:
        for said in received(estimates):
            line = {field: getattr(said, field) for field, _ in Estimate._fields_}
            print(json.dumps(line | {"received_ns": time.time_ns()}), flush=True)
        for body, subscriber in frames.items():
            got = [(frame.estimate, frame.index, frame.count) for frame in received(subscriber)]
            if got:
                print(json.dumps({"body": body, "frames": len(got), "last": got[-1]}), flush=True)
        time.sleep(0.0005)

if __name__ == "__main__":
    main(float((sys.argv[1:2] or [10])[0]), *sys.argv[2:])
