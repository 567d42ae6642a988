"""Checks one MCAP file with one client: check_clients.py mcap|rerun|rosbags FILE."""

import collections
import json
import os
import pathlib
import re
import subprocess
import sys
import tempfile


def fail(text):
    sys.exit(f"FAILED: {text}")


def check_mcap(path):
    """The Python reader: every checksum, every protobuf, every JSON against its schema."""
    import jsonschema
    from mcap.reader import make_reader
    from mcap_protobuf.decoder import DecoderFactory

    counts = collections.Counter()
    last = 0
    with open(path, "rb") as file:
        reader = make_reader(
            file, decoder_factories=[DecoderFactory()], validate_crcs=True
        )
        summary = reader.get_summary()
        # In the order of the file: a file that is not sorted is seen.
        for schema, channel, message in reader.iter_messages(log_time_order=False):
            if message.log_time < last:
                fail(f"{channel.topic}: log time {message.log_time} after {last}")
            last = message.log_time
            counts[channel.topic] += 1
            if channel.message_encoding == "json" and schema.encoding == "jsonschema":
                definition = json.loads(schema.data)
                jsonschema.Draft202012Validator.check_schema(definition)
                jsonschema.validate(json.loads(message.data), definition)
    decoded = 0
    with open(path, "rb") as file:
        reader = make_reader(
            file, decoder_factories=[DecoderFactory()], validate_crcs=True
        )
        protobuf = {
            c.topic for c in summary.channels.values() if c.message_encoding == "protobuf"
        }
        for schema, channel, message, content in reader.iter_decoded_messages(
            topics=sorted(protobuf)
        ):
            if content.DESCRIPTOR.full_name != schema.name:
                fail(f"{channel.topic}: {content.DESCRIPTOR.full_name}, not {schema.name}")
            decoded += 1
        attachments = [a.name for a in reader.iter_attachments()]
    if sum(counts.values()) != summary.statistics.message_count:
        fail(f"{sum(counts.values())} messages, {summary.statistics.message_count} claimed")
    for topic in sorted(counts):
        print(f"mcap      {counts[topic]:6d} {topic}")
    print(f"mcap      {decoded} protobuf messages decoded, attachments {attachments}")


def run(*command, **options):
    done = subprocess.run(command, capture_output=True, text=True, **options)
    output = re.sub(r"\x1b\[[0-9;]*m", "", done.stdout + done.stderr)
    if done.returncode != 0:
        fail(f"{' '.join(command)}: {output}")
    return output


def check_rerun(path):
    """Rerun: its full check, conversion, verification, and that transforms are drawn."""
    rerun = str(pathlib.Path(sys.executable).with_name("rerun"))
    output = run(rerun, "mcap", "check", "--full", path)
    for line in output.strip().splitlines():
        print(f"rerun     check: {line}")
    if re.search(r"\b(error|warn(ing)?|invalid)\b", output, re.I):
        fail("rerun mcap check complains")
    with tempfile.TemporaryDirectory() as directory:
        converted = os.path.join(directory, "out.rrd")
        output = run(
            rerun, "mcap", "convert", "--application-id", "enact", path, "-o", converted
        )
        for line in output.strip().splitlines():
            print(f"rerun     convert: {line}")
        if re.search(r"\b(error|warn(ing)?)\b", output, re.I):
            fail("rerun mcap convert complains")
        output = run(rerun, "rrd", "verify", converted)
        for line in output.strip().splitlines():
            print(f"rerun     verify: {line}")
        printed = run(rerun, "rrd", "print", "-v", converted)
        for what in ("Transform3D:translation", "Boxes3D", "Cylinders3D"):
            print(f"rerun     {what}: {printed.count(what)}")
        if "Transform3D:translation" not in printed:
            fail("rerun draws no transforms")


def check_rosbags(path):
    """rosbags reads the ROS 2 profile only: it must say so, or read what is CDR."""
    from rosbags.highlevel import AnyReader, AnyReaderError

    try:
        with AnyReader([pathlib.Path(path)]) as reader:
            count = sum(1 for _ in reader.messages())
            print(f"rosbags   {count} messages on {sorted(reader.topics)}")
    except AnyReaderError as error:
        if "ros2" not in str(error).lower():
            fail(f"rosbags: {error}")
        print(f"rosbags   does not apply: {error}")


if __name__ == "__main__":
    {"mcap": check_mcap, "rerun": check_rerun, "rosbags": check_rosbags}[sys.argv[1]](
        sys.argv[2]
    )
