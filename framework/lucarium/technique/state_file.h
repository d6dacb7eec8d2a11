// SPDX-License-Identifier: Apache-2.0
// Files of saved states: docs/state_files.md is their format.
#pragma once
#include <cstdint>
#include <filesystem>
#include <fstream>
#include <functional>
#include <memory>
#include <string>
#include <utility>
#include <vector>

#include "lucarium/base/hash.h"
#include "lucarium/technique/technique_state.h"

namespace lucarium {

/// What a state belongs to.
struct StateHeader {
  std::string program_version;
  std::string scene, scene_hash;  ///< as it was named, and Scene::hash()
  std::string technique, technique_version;
  std::vector<std::pair<std::string, std::string>> parameters;  ///< all of them
  std::string path_set;                                         ///< PathSet::to_string()
  int max_bounces = -1;
  uint64_t seed = 1;
  uint32_t width = 0, height = 0;  ///< of the image that was rendered; for people
  double seconds = 0;              ///< that preparing and propagating took; for people
};

/// A chunk as it stands in the file.
struct StateChunk {
  std::string name;
  uint32_t element_bytes = 0;
  uint64_t elements = 0;
  bool compressed = false;
  uint64_t stored_bytes = 0;
  uint64_t offset = 0;  ///< of its data in the file
  Hash128 checksum;     ///< of them
};

/// Writes what `put_chunks` puts, whole or not at all. Replaces what is there: callers ask before. Throws Error{input}
/// where the file cannot be written, and what put_chunks throws.
void write_state_file(const std::filesystem::path& file, const StateHeader& header, bool compress,
                      const std::function<void(StateWriter&)>& put_chunks);

/// A state in a file. Opening it reads all of it once: anything that is cut off, damaged or impossible is Error{input},
/// and so is a file of a newer form. It stays open, so that chunks are those of the file that was opened, even if
/// another one has taken its name since, as when the state is saved again. For one thread at a time.
class StateFile : public StateReader {
 public:
  explicit StateFile(std::filesystem::path file);
  const std::filesystem::path& path() const { return file_; }
  const StateHeader& header() const { return header_; }
  const std::vector<StateChunk>& chunks() const { return chunks_; }
  uint64_t file_bytes() const { return file_bytes_; }
  bool has(const std::string& name) const override { return find(name) != nullptr; }

 protected:
  size_t element_bytes(const std::string& name) const override;
  uint64_t count(const std::string& name) const override;
  void get_bytes(const std::string& name, void* target) const override;
  std::string source() const override { return file_.string(); }

 private:
  const StateChunk* find(const std::string& name) const;
  std::filesystem::path file_;
  mutable std::ifstream in_;  ///< reading moves it
  StateHeader header_;
  std::vector<StateChunk> chunks_;
  uint64_t file_bytes_ = 0;
};

}  // namespace lucarium
