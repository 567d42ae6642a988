"""What many recordings share, with the work on as many machines as Ray has: `on_ray.py FOLDER NAME…`.

Each take is a pure function of its bytes and of where it is asked; only its block, a few kilobytes, travels.
"""

import sys

import ray

import enact_motion

FOLDER, *NAMES = sys.argv[1:]


def reduced(row, question=None):
    take = enact_motion.read(bytes(row["bytes"]))
    return {"block": enact_motion.reduce(take, shared=NAMES, question=question) or b""}


if __name__ == "__main__":
    ray.init(num_cpus=2, include_dashboard=False, log_to_driver=False)
    recordings = ray.data.read_binary_files(FOLDER, file_extensions=["mcap"]).materialize()
    blocks, answer = [], None
    while not isinstance(answer, enact_motion.Fit):
        rows = recordings.map(reduced, fn_kwargs={"question": answer}).take_all()
        blocks += [row["block"] for row in rows if row["block"]]
        answer = enact_motion.join(blocks)
    for name, of in answer.parameters.items():
        print(name, of.value)
