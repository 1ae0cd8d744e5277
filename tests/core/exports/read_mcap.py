"""Reads a whole MCAP file of ROS 2 as mcap.dev/spec states it and asserts everything that can be told from the file
itself: order of records, check sums, indices, offsets, counts. Messages are decoded by the text of their own schema,
so that texts and bytes are checked against each other."""

import ctypes
import struct
import zlib

MAGIC = b"\x89MCAP0\r\n"
(HEADER, FOOTER, SCHEMA, CHANNEL, MESSAGE, CHUNK, MESSAGE_INDEX, CHUNK_INDEX) = range(1, 9)
STATISTICS, METADATA, METADATA_INDEX, SUMMARY_OFFSET, DATA_END = 0x0B, 0x0C, 0x0D, 0x0E, 0x0F


def lz4(data, size):
    library = ctypes.CDLL("liblz4.so.1")
    for name in ("LZ4F_createDecompressionContext", "LZ4F_decompress", "LZ4F_freeDecompressionContext"):
        getattr(library, name).restype = ctypes.c_size_t
    context = ctypes.c_void_p()
    assert library.LZ4F_createDecompressionContext(ctypes.byref(context), ctypes.c_uint(100)) == 0
    out = ctypes.create_string_buffer(size)
    filled, read = ctypes.c_size_t(size), ctypes.c_size_t(len(data))
    left = library.LZ4F_decompress(context, out, ctypes.byref(filled), data, ctypes.byref(read), None)
    library.LZ4F_freeDecompressionContext(context)
    assert (left, filled.value, read.value) == (0, size, len(data)), "no whole frame of LZ4"
    return out.raw


class Content:
    """The fields of a record, one after the other."""

    def __init__(self, data):
        self.data, self.at = data, 0

    def number(self, code):
        value, = struct.unpack_from("<" + code, self.data, self.at)
        self.at += struct.calcsize(code)
        return value

    def numbers(self, codes):
        return [self.number(code) for code in codes]

    def bytes(self, size):
        assert self.at + size <= len(self.data)
        self.at += size
        return self.data[self.at - size:self.at]

    def text(self):
        return self.bytes(self.number("I")).decode()

    def map(self, key, value):
        entries = Content(self.bytes(self.number("I")))
        read = lambda code: entries.text() if code == "text" else entries.number(code)
        pairs = []
        while entries.at < len(entries.data):
            pairs.append((read(key), read(value)))
        assert len(dict(pairs)) == len(pairs), "a key stands twice"
        return dict(pairs)

    def end(self):
        assert self.at == len(self.data), "a record is longer than its fields"


def records(data, start, end):
    """Kind, content, and where the record starts and ends."""
    while start < end:
        kind, size = struct.unpack_from("<BQ", data, start)
        assert start + 9 + size <= end, "a record reaches beyond its section"
        yield kind, Content(data[start + 9:start + 9 + size]), start, start + 9 + size
        start += 9 + size


class Types:
    """The types of a schema's text; decodes CDR."""

    NUMBERS = {"bool": "?", "int8": "b", "uint8": "B", "int16": "h", "uint16": "H", "int32": "i", "uint32": "I",
               "int64": "q", "uint64": "Q", "float32": "f", "float64": "d"}

    def __init__(self, name, text):
        package, kind, short = name.split("/")
        assert kind == "msg"
        self.root, self.types = package + "/" + short, {}
        for part in ("MSG: " + self.root + "\n" + text).split("=" * 80 + "\n"):
            head, *lines = part.split("\n")
            assert head.startswith("MSG: ") and head[5:] not in self.types, head
            fields = [line.split("#")[0].split() for line in lines if "=" not in line]  # constants have no bytes
            self.types[head[5:]] = [(f[1], f[0]) for f in fields if f]
        wanted, known = [self.root], set()
        while wanted:
            name = wanted.pop()
            known.add(name)
            for _, kind in self.types[name]:
                kind = kind.split("[")[0]
                if kind not in self.NUMBERS and kind != "string" and kind not in known:
                    wanted.append(kind)
        assert known == set(self.types), "types that nobody uses"

    def decode(self, data):
        assert data[:4] == b"\0\1\0\0", "not CDR with the least significant byte first"
        self.data, self.at = data[4:], 0
        message = self.value(self.root)
        assert self.at == len(self.data), "the message is longer than its definition"
        return message

    def bytes(self, size):
        assert self.at + size <= len(self.data)
        self.at += size
        return self.data[self.at - size:self.at]

    def number(self, code):
        size = struct.calcsize(code)
        assert not any(self.bytes(-self.at % size)), "padding that is not 0"
        return struct.unpack("<" + code, self.bytes(size))[0]

    def value(self, kind):
        if kind == "uint8[]":
            return self.bytes(self.number("I"))
        if kind.endswith("[]"):
            return [self.value(kind[:-2]) for _ in range(self.number("I"))]
        if kind.endswith("]"):  # an array of a fixed length, T[N]
            own, length = kind[:-1].split("[")
            return [self.value(own) for _ in range(int(length))]
        if kind in self.NUMBERS:
            return self.number(self.NUMBERS[kind])
        if kind == "string":
            text = self.bytes(self.number("I"))
            assert text[-1:] == b"\0" and b"\0" not in text[:-1]
            return text[:-1].decode()
        return {name: self.value(own) for name, own in self.types[kind]}


class File:
    """header, metadata, schemas, channels, chunks and messages (dictionaries, in the order of the file)."""

    def __init__(self, path, ros=True):
        data = path.read_bytes()
        assert data[:8] == MAGIC and data[-8:] == MAGIC
        self.schemas, self.channels, self.metadata, self.messages, self.chunks = {}, {}, {}, [], []
        self.ros, self.types, self.owned = ros, {}, {}  # owned: what the summary must repeat, by its kind
        self.walk = list(records(data, 8, len(data) - 8))
        kinds = [kind for kind, *_ in self.walk]
        assert kinds[0] == HEADER and kinds[-1] == FOOTER and kinds.count(DATA_END) == 1
        self.header = {"profile": self.walk[0][1].text(), "library": self.walk[0][1].text()}
        self.walk[0][1].end()
        end = kinds.index(DATA_END)
        self.read_data(data, self.walk[1:end])
        _, content, start, after = self.walk[end]
        assert content.number("I") == zlib.crc32(data[:start]), "check sum of the data"
        content.end()
        self.read_summary(data, after, self.walk[end + 1:])

    def own(self, kind, value):
        self.owned.setdefault(kind, []).append(value)

    def read_data(self, data, walk):
        walk = list(walk)
        while walk:
            kind, content, start, end = walk.pop(0)
            if kind == CHUNK:
                indices = []
                while walk and walk[0][0] == MESSAGE_INDEX:
                    indices.append(walk.pop(0))
                self.read_chunk(content, start, end, indices)
            else:
                assert kind == METADATA, kind
                name = content.text()
                self.metadata[name] = content.map("text", "text")
                content.end()
                self.own(METADATA_INDEX, (start, end - start, name))

    def read_chunk(self, content, start, end, indices):
        first, last, size, crc = content.numbers("QQQI")
        compression = content.text()
        packed = content.bytes(content.number("Q"))
        content.end()
        assert compression in ("", "lz4")
        plain = lz4(packed, size) if compression else packed
        assert len(plain) == size and zlib.crc32(plain) == crc, "a chunk's check sum"
        index = {}
        for kind, own, offset, _ in records(plain, 0, size):
            if kind == SCHEMA:
                number = own.number("H")
                assert number > 0 and number not in self.schemas
                self.schemas[number] = {"name": own.text(), "encoding": own.text(), "text": own.text()}
                self.own(SCHEMA, own.data)
            elif kind == CHANNEL:
                number, schema = own.numbers("HH")
                assert schema in self.schemas and number not in self.channels
                self.channels[number] = {"schema": schema, "topic": own.text(), "encoding": own.text(),
                                         "metadata": own.map("text", "text")}
                self.own(CHANNEL, own.data)
            else:
                assert kind == MESSAGE, kind
                channel, sequence, time, published = own.numbers("HIQQ")
                index.setdefault(channel, []).append((time, offset))
                self.add(channel, sequence, time, published, own.bytes(len(own.data) - own.at))
            own.end()
        times = [time for entries in index.values() for time, _ in entries] or [0]
        assert (first, last) == (min(times), max(times)), "a chunk's times"
        stored, offsets = {}, {}
        for _, own, offset, _ in indices:
            channel = own.number("H")
            assert channel not in stored
            offsets[channel] = offset
            stored[channel] = list(struct.iter_unpack("<QQ", own.bytes(own.number("I"))))
            own.end()
        assert stored == index, "a chunk's messages"
        length = sum(after - offset for _, _, offset, after in indices)
        self.own(CHUNK_INDEX, (first, last, start, end - start, offsets, length, compression, len(packed), size))
        self.chunks.append({"compression": compression, "size": size, "messages": sum(map(len, index.values()))})

    def add(self, channel, sequence, time, published, data):
        own = self.channels[channel]
        assert sequence == sum(m["topic"] == own["topic"] for m in self.messages), "a message's number"
        if self.ros:
            schema = self.schemas[own["schema"]]
            if own["schema"] not in self.types:
                self.types[own["schema"]] = Types(schema["name"], schema["text"])
            data = self.types[own["schema"]].decode(data)
        self.messages.append({"topic": own["topic"], "channel": channel, "time": time, "value": data})
        assert published == time

    def read_summary(self, data, start, walk):
        groups, found = [], {}
        for kind, content, offset, end in walk[:-1]:
            if kind == SUMMARY_OFFSET:
                found.setdefault(kind, []).append(tuple(content.numbers("BQQ")))
                content.end()
                continue
            assert SUMMARY_OFFSET not in found
            if not groups or groups[-1][0] != kind:
                groups.append((kind, offset, 0))
            groups[-1] = (kind, groups[-1][1], end - groups[-1][1])
            if kind in (SCHEMA, CHANNEL):
                value = content.data
            elif kind == CHUNK_INDEX:
                value = (*content.numbers("QQQQ"), content.map("H", "Q"), content.number("Q"), content.text(),
                         *content.numbers("QQ"))
            elif kind == METADATA_INDEX:
                value = (*content.numbers("QQ"), content.text())
            else:
                assert kind == STATISTICS, kind
                value = (*content.numbers("QHIIIIQQ"), content.map("H", "Q"))
            if kind not in (SCHEMA, CHANNEL):
                content.end()
            found.setdefault(kind, []).append(value)
        assert found.pop(SUMMARY_OFFSET) == groups and len(set(g[0] for g in groups)) == len(groups)
        times = [message["time"] for message in self.messages] or [0]
        counts = {c: sum(m["channel"] == c for m in self.messages) for c in self.channels}
        self.own(STATISTICS, (len(self.messages), len(self.schemas), len(self.channels), 0, len(self.metadata),
                              len(self.chunks), min(times), max(times), counts))
        assert found == self.owned, "the summary"
        _, content, footer, _ = walk[-1]
        first, offsets, crc = content.numbers("QQI")
        content.end()
        assert first == start
        assert offsets == next(offset for kind, _, offset, _ in walk if kind == SUMMARY_OFFSET)
        assert crc == zlib.crc32(data[start:footer + 9 + 16]), "check sum of the summary"


def cloud(value):
    """The points of a PointCloud2, rows by columns, with a field for each of its own."""
    import numpy as np

    types = [None, "i1", "u1", "i2", "u2", "i4", "u4", "f4", "f8"]
    fields = value["fields"]
    assert all(f["count"] == 1 and f["offset"] % np.dtype(types[f["datatype"]]).itemsize == 0 for f in fields)
    dtype = np.dtype({"names": [f["name"] for f in fields], "formats": ["<" + types[f["datatype"]] for f in fields],
                      "offsets": [f["offset"] for f in fields], "itemsize": value["point_step"]})
    assert not value["is_bigendian"] and value["row_step"] == value["width"] * value["point_step"]
    return np.frombuffer(value["data"], dtype).reshape(value["height"], value["width"])
