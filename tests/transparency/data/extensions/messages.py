"""What is sent and stored: JSON, MessagePack, CBOR, protobuf, ZeroMQ, XML, HDF5."""

import cbor2
import h5py
import msgpack
import orjson
import zmq
from google.protobuf import json_format, struct_pb2, wrappers_pb2
from lxml import etree

SPEED = 0.5
COUNT = 3
NAME = "front"
DATA = {"a": [1, SPEED, NAME, COUNT], NAME: f"{NAME}/{COUNT}", "z": {"q": 2.5}}

print(orjson.dumps(DATA), orjson.dumps([COUNT, SPEED * 2], option=orjson.OPT_INDENT_2))
print(msgpack.packb(DATA), msgpack.packb([SPEED], use_single_float=True), cbor2.dumps(DATA))

struct = struct_pb2.Struct()
struct["speed"] = SPEED
struct[NAME] = NAME + "!"
struct.update({"n": COUNT, "l": [1, SPEED]})
print(json_format.MessageToJson(struct, sort_keys=True))
print(wrappers_pb2.DoubleValue(value=SPEED), wrappers_pb2.StringValue(value=NAME))

context = zmq.Context(COUNT)
sender, receiver = context.socket(zmq.PAIR), context.socket(zmq.PAIR)
sender.setsockopt(zmq.SNDHWM, COUNT)
sender.bind("inproc://" + NAME)
receiver.connect(f"inproc://{NAME}")
sender.send_string(NAME)
sender.send_json({"v": SPEED})
sender.send_pyobj([SPEED])
print(receiver.recv_string(), receiver.recv_json(), receiver.recv_pyobj())
for socket in (sender, receiver):
    socket.close(linger=0)
context.term()

robot = etree.Element("robot", name=NAME)
etree.SubElement(robot, "link", {"mass": str(SPEED), "n": NAME}).text = NAME
print(etree.tostring(robot), robot.xpath("//link[@n=$n]", n=NAME)[0].get("mass"))

with h5py.File("a.h5", "w", driver="core", backing_store=False) as file:
    made = file.create_dataset(NAME, (COUNT, 2), dtype="f8", compression="gzip")
    made[COUNT - 1, 0] = SPEED
    made.attrs["unit"] = NAME
    made.attrs["gain"] = SPEED
    print(made[:], dict(made.attrs), list(file))
