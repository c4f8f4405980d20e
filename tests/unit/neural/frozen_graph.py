"""A TensorFlow graph as OpenCV reads it, written without TensorFlow."""

import numpy as np
from google.protobuf import descriptor_pb2, descriptor_pool, message_factory, text_format

# The messages of TensorFlow's graph.proto, as far as they are needed: (number, name, type); brackets mark what is repeated.
TENSORFLOW = {
    "Dimension": [(1, "size", "int64")],
    "Shape": [(2, "dim", "[Dimension]")],
    "Tensor": [(1, "dtype", "int32"), (2, "tensor_shape", "Shape"), (4, "tensor_content", "bytes")],
    "List": [(3, "i", "[int64]")],
    "Value": [
        *((1, "list", "List"), (2, "s", "bytes"), (3, "i", "int64"), (4, "f", "float")),
        *((5, "b", "bool"), (6, "type", "int32"), (7, "shape", "Shape"), (8, "tensor", "Tensor")),
    ],
    "Attribute": [(1, "key", "string"), (2, "value", "Value")],
    "Node": [(1, "name", "string"), (2, "op", "string"), (3, "input", "[string]"), (5, "attr", "[Attribute]")],
    "GraphDef": [(1, "node", "[Node]")],
}
# Types of numbers, by TensorFlow's count.
FLOAT, INT32 = 1, 3


def tensorflow_messages():
    """The classes of TENSORFLOW by name."""
    file = descriptor_pb2.FileDescriptorProto(name="graph.proto", package="tensorflow", syntax="proto3")
    for message, fields in TENSORFLOW.items():
        described = file.message_type.add(name=message)
        for number, name, kind in fields:
            bare = kind.strip("[]")
            field = described.field.add(name=name, number=number, label=3 if kind != bare else 1)
            if bare in TENSORFLOW:
                field.type, field.type_name = field.TYPE_MESSAGE, f".tensorflow.{bare}"
            else:
                field.type = getattr(field, f"TYPE_{bare.upper()}")
    pool = descriptor_pool.DescriptorPool()
    pool.Add(file)
    factory = message_factory.MessageFactory(pool)
    return {name: factory.GetPrototype(pool.FindMessageTypeByName(f"tensorflow.{name}")) for name in TENSORFLOW}


class FrozenGraph:
    """A TensorFlow graph under construction, whose axes are N H W C."""

    def __init__(self):
        self.kinds = tensorflow_messages()
        self.message = self.kinds["GraphDef"]()

    def add(self, name, operator, *inputs, **attributes):
        node = self.message.node.add(name=name, op=operator, input=inputs)
        for key, value in attributes.items():
            node.attr.add(key=key, value=self.kinds["Value"](**value))
        return name

    def picture(self, name, height, width):
        """The input: [1, height, width, 3]."""
        return self.add(name, "Placeholder", dtype={"type": FLOAT}, shape={"shape": shape_of((1, height, width, 3))})

    def given(self, name, values, dtype):
        values = np.array(values, {FLOAT: np.float32, INT32: np.int32}[dtype])
        tensor = {"dtype": dtype, "tensor_shape": shape_of(values.shape), "tensor_content": values.tobytes()}
        return self.add(name, "Const", dtype={"type": dtype}, value={"tensor": tensor})

    def averaged(self, name, source, height, width):
        size = {"list": {"i": [1, height, width, 1]}}
        return self.add(name, "AvgPool", source, ksize=size, strides=size, padding={"s": b"VALID"}, T={"type": FLOAT})

    def convolved(self, name, source, weights, biases):
        """A 1x1 convolution; weights are [outputs, inputs]."""
        kernel = self.given(f"{name}/weights", np.array(weights).T[None, None], FLOAT)
        pixel = {"list": {"i": [1, 1, 1, 1]}}
        product = self.add(f"{name}/Conv2D", "Conv2D", source, kernel, strides=pixel, padding={"s": b"VALID"}, T={"type": FLOAT})
        return self.add(name, "BiasAdd", product, self.given(f"{name}/biases", biases, FLOAT), T={"type": FLOAT})

    def reshaped(self, name, source, shape):
        return self.add(name, "Reshape", source, self.given(f"{name}/shape", shape, INT32), T={"type": FLOAT})

    def activated(self, name, source):
        return self.add(name, "Sigmoid", source, T={"type": FLOAT})

    def constant(self, name, source, values):
        """The values, for any one-pixel source of three channels: OpenCV accepts no constants as inputs."""
        values = np.array(values)
        numbers = self.convolved(f"{name}/numbers", source, np.zeros((values.size, 3)), values.ravel())
        return self.reshaped(name, numbers, values.shape)

    def binary(self):
        return self.message.SerializeToString(deterministic=True)

    def text(self):
        """The text file that OpenCV needs beside the binary: the nodes without the weights."""
        nodes = [node for node in self.message.node if node.op != "Const"]
        return text_format.MessageToString(self.kinds["GraphDef"](node=nodes)).encode()


def shape_of(sizes):
    return {"dim": [{"size": size} for size in sizes]}
