// The extension module scanmill._core: datasets and simulation as numpy arrays. Users call the functions in
// scanmill/*.py, whose docstrings state shapes and units. The types are in _core.pyi.

#include <dlfcn.h>
#include <fmt/format.h>
#include <pybind11/pybind11.h>
#include <pybind11/stl.h>

#include <algorithm>
#include <cstdlib>
#include <filesystem>
#include <memory>
#include <new>
#include <optional>
#include <stdexcept>
#include <string>
#include <utility>
#include <vector>

#include "base/error.h"
#include "base/file.h"
#include "base/input_budget.h"
#include "base/terminal.h"
#include "config/fields.h"
#include "config/resources.h"
#include "config/text.h"
#include "config/version.h"
#include "dataset/json_text.h"
#include "dataset/manifest.h"
#include "dataset/reader.h"
#include "dataset/scan_store.h"
#include "python/arrays.h"

namespace py = pybind11;

namespace scanmill {

namespace {

// Sets the environment variable SCANMILL_RESOURCES to the package's folder `share` beside this module, if the folder
// exists and the variable is not yet set.
void findResources() {
  Dl_info here{};
  if (::dladdr(reinterpret_cast<const void*>(&findResources), &here) == 0 || here.dli_fname == nullptr) return;
  const std::filesystem::path share = std::filesystem::path(here.dli_fname).parent_path() / "share";
  if (isFolder(share)) ::setenv("SCANMILL_RESOURCES", share.c_str(), 0);
}

// Returns the beam table of a dataset's sensor as arrays of the shape rings x columns, including beams without returns.
py::object beamsOf(const ScanStore& store, const std::string& sensor, double time) {
  const std::shared_ptr<const BeamTable> table = store.beams(sensor, time);
  if (table == nullptr || table->direction.empty()) {
    throw InputError({store.path().string()},
                     "the beams of the sensor '" + sensor + "' are unknown, since there is no manifest");
  }
  const auto rings = static_cast<py::ssize_t>(table->rings);
  const auto columns = static_cast<py::ssize_t>(table->columns);
  py::dict beams;
  beams["rings"] = table->rings;
  beams["columns"] = table->columns;
  beams["direction"] = arrayOf<double>(std::vector<Vec3d>(table->direction), {rings, columns, 3});
  if (!table->origin.empty()) {
    beams["origin"] = arrayOf<float>(std::vector<Vec3f>(table->origin), {rings, columns, 3});
  }
  if (!table->time.empty()) beams["time"] = arrayOf<float>(std::vector<float>(table->time), {rings, columns});
  return beams;
}

// Returns the arguments of Stagger for a sensor; nothing if the manifest does not describe the sensor.
std::optional<py::tuple> staggerIn(const ScanStore& store, const std::string& sensor) {
  if (store.manifest() == nullptr) return {};
  for (const SensorRecord& record : store.manifest()->sensors) {
    if (record.name == sensor) return staggerOf(record.beams);
  }
  return {};
}

// Returns the manifest as JSON without its samples, whose records recordOf() finds; nothing if there is no manifest.
std::optional<std::string> manifestOf(const ScanStore& store) {
  if (store.manifest() == nullptr) return {};
  Manifest head = *store.manifest();
  head.samples.clear();
  for (ShardRecord& shard : head.shards) shard.samplesSha256.clear();
  return toJson(head);
}

const SampleRecord* recordOf(const ScanStore& store, std::size_t sample) {
  if (store.manifest() == nullptr) return nullptr;
  const std::string& key = store.keys().at(sample);
  const std::vector<SampleRecord>& records = store.manifest()->samples;
  if (sample < records.size() && records[sample].key == key) return &records[sample];
  const auto record = std::ranges::find(records, key, &SampleRecord::key);
  return record == records.end() ? nullptr : &*record;
}

// Removes the columns that are not in `columns`. Throws InputError for a name that the scan lacks.
void keepColumns(const ScanStore& store, std::size_t sample, const std::vector<std::string>& columns, Scan& scan) {
  std::vector<std::string> names =
      scan.size() == 0 && store.manifest() != nullptr ? store.manifest()->columns : columnNames(scan);
  names.erase(names.begin(), names.begin() + 3);  // removes x, y and z, which come first
  for (const std::string& name : columns) {
    if (std::ranges::find(names, name) != names.end()) continue;
    throw InputError({store.path().string()}, "the scan of " + store.keys().at(sample) + " has no column '" + name +
                                                  "'" + suggestion(name, names));
  }
  visitColumns(scan, [&](std::string_view name, auto& values) {
    if (std::ranges::find(columns, name) == columns.end()) values.clear();
  });
  std::erase_if(scan.foreign, [](const ForeignColumn& column) {
    return std::visit([](const auto& values) { return values.empty(); }, column.values);
  });
}

// Returns one scan of a sample as arrays. `sensor`: empty for the first sensor. `columns`: nothing for all columns.
py::dict readScan(const ScanStore& store, std::size_t sample, const std::string& sensor,
                  const std::optional<std::vector<std::string>>& columns, std::uint32_t revolution) {
  Scan scan;
  {
    const py::gil_scoped_release released;
    const std::vector<StoredScan> scans = store.scans(sample, sensor);
    const std::string sensorName = lowerCase(scans.front().sensor);
    const auto stored = std::ranges::find_if(
        scans, [&](const StoredScan& s) { return s.revolution == revolution && lowerCase(s.sensor) == sensorName; });
    if (stored == scans.end()) {
      throw InputError({store.path().string()}, "the sample " + store.keys().at(sample) + " has no revolution " +
                                                    std::to_string(revolution) + " of the sensor '" +
                                                    scans.front().sensor + "'");
    }
    scan = store.decode(sample, *stored);
    if (columns) keepColumns(store, sample, *columns, scan);
  }
  const bool empty = scan.size() == 0;
  py::dict arrays = arraysOf(std::move(scan));
  if (empty && store.manifest() != nullptr) addEmptyColumns(store.manifest()->columns, arrays);
  if (!empty || !columns) return arrays;
  py::dict selected;
  selected["xyz"] = arrays["xyz"];
  for (const std::string& name : *columns) selected[py::str(name)] = arrays[py::str(name)];
  return selected;
}

// Returns the split of each sample; empty texts without a manifest.
std::vector<std::string> splitsOf(const ScanStore& store) {
  std::vector<std::string> splits;
  for (std::size_t i = 0; i < store.keys().size(); ++i) {
    const SampleRecord* const record = recordOf(store, i);
    splits.push_back(record == nullptr ? std::string() : record->split);
  }
  return splits;
}

std::optional<std::string> recordJson(const ScanStore& store, std::size_t sample) {
  const SampleRecord* const record = recordOf(store, sample);
  return record == nullptr ? std::nullopt : std::optional(sampleJson(*record));
}

// Returns sensor, method and revolution of each scan of a sample.
std::vector<std::tuple<std::string, std::string, std::uint32_t>> scansOf(const ScanStore& store, std::size_t sample) {
  std::vector<std::tuple<std::string, std::string, std::uint32_t>> scans;
  for (const StoredScan& scan : store.scans(sample)) scans.emplace_back(scan.sensor, scan.method, scan.revolution);
  return scans;
}

std::optional<std::string> objectsOf(const ScanStore& store, std::size_t sample) {
  const py::gil_scoped_release released;
  const std::optional<SampleObjects> objects = store.objects(sample);
  return objects ? std::optional(objectsJson(*objects, store.manifest()->ontology)) : std::nullopt;
}

std::optional<py::bytes> voxelsOf(const ScanStore& store, std::size_t sample, const std::string& sensor) {
  std::optional<std::string> bytes;
  {
    const py::gil_scoped_release released;
    bytes = store.voxels(sample, sensor);
  }
  return bytes ? std::optional(py::bytes(*bytes)) : std::nullopt;
}

std::unique_ptr<ScanStore> openStore(const std::string& path) {
  return std::make_unique<ScanStore>(path, ScanStore::Digests::Compared);
}

void defineStore(py::module_& module) {
  py::class_<ScanStore>(module, "Store")
      .def(py::init([](const std::string& path) {
             const py::gil_scoped_release released;
             return openStore(path);
           }),
           py::arg("path"))
      .def_property_readonly("path", [](const ScanStore& s) { return s.path().string(); })
      .def_property_readonly("keys", &ScanStore::keys)
      .def_property_readonly("manifest", &manifestOf)
      .def_property_readonly("splits", &splitsOf)
      .def("record", &recordJson, py::arg("sample"))
      .def("scans", &scansOf, py::arg("sample"))
      .def("read", &readScan, py::arg("sample"), py::arg("sensor") = "", py::arg("columns") = py::none(),
           py::arg("revolution") = 0)
      .def("objects", &objectsOf, py::arg("sample"))
      .def("voxels", &voxelsOf, py::arg("sample"), py::arg("sensor") = "")
      .def("beams", &beamsOf, py::arg("sensor"), py::arg("time") = 0.0)
      .def("stagger", &staggerIn, py::arg("sensor"))
      .def(py::pickle([](const ScanStore& s) { return py::make_tuple(s.path().string()); },
                      [](const py::tuple& state) { return openStore(state[0].cast<std::string>()); }));
}

}  // namespace

PYBIND11_MODULE(_core, module) {
  findResources();
  static const py::exception<Error> error(module, "Error", PyExc_RuntimeError);
  static const py::exception<InputError> inputError(module, "InputError", PyExc_ValueError);
  py::register_exception_translator([](std::exception_ptr thrown) {
    try {
      if (thrown) std::rethrow_exception(std::move(thrown));
    } catch (const InputError& e) {
      PyErr_SetString(inputError.ptr(), forTerminal(e.what()).c_str());
    } catch (const Error& e) {
      PyErr_SetString(error.ptr(), forTerminal(e.what()).c_str());
    } catch (const std::bad_alloc& e) {
      PyErr_SetString(PyExc_MemoryError, reasonOf(e).c_str());
    } catch (const std::length_error& e) {
      PyErr_SetString(PyExc_MemoryError, reasonOf(e).c_str());
    }
  });
  defineStore(module);
  defineJobs(module);
  defineSimulator(module);
  definePassRecorder(module);
  module.def(
      "decode",
      [](const std::string& name, const py::bytes& data) {
        const std::string bytes = data;
        Scan scan;
        {
          const py::gil_scoped_release released;
          scan = decodeMember(name, bytes);
        }
        return arraysOf(std::move(scan));
      },
      py::arg("name"), py::arg("data"));
  module.def(
      "set_input_limit",
      [](double factor) {
        static std::unique_ptr<InputLimitFactor> set;
        if (!(factor >= 1)) throw InputError(fmt::format("set_input_limit: {} is not a number of at least 1", factor));
        set.reset();
        set = std::make_unique<InputLimitFactor>(factor);
      },
      py::arg("factor"),
      "Multiplies by `factor`, at least 1, the limits of what small files may cost: files, copies, memory and time\n"
      "(docs/reliability.md). For all scenes that are loaded from now on.");
  module.attr("resource_folder") = resourceFolder().string();
  module.attr("__version__") = kVersion;
}

}  // namespace scanmill
