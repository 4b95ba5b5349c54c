// Walks the tables that rosbag2's SQLite storage has had since its first version: topics(id, name,
// type, serialization_format) and messages(topic_id, timestamp, data). The file is somebody else's:
// it is opened for reading alone, and nothing that it says is executed.
#include "tools/recording/rosbag_db3.h"

#include <sqlite3.h>
#include <zstd.h>

#include <filesystem>
#include <memory>
#include <optional>

#include "shared/files/input_error.h"
#include "shared/mcap/ros_messages.h"
#include "tools/recording/ros_rows.h"

namespace sanso::recording {
namespace {

using files::InputError;

constexpr int kMostBytes = 64 << 20;  // of a message; larger ones are no states of joints
constexpr char kExpected[] = "a bag of `ros2 bag` (storage sqlite3), closed and whole";

struct Closed {
  void operator()(sqlite3* db) const { sqlite3_close(db); }
  void operator()(sqlite3_stmt* statement) const { sqlite3_finalize(statement); }
};
using Database = std::unique_ptr<sqlite3, Closed>;
using Statement = std::unique_ptr<sqlite3_stmt, Closed>;

[[noreturn]] void refuse(const std::string& path, sqlite3* db, int code) {
  const char* what = db != nullptr ? sqlite3_errmsg(db) : sqlite3_errstr(code);
  const bool foreign = code == SQLITE_NOTADB;
  throw InputError(path, 0, "", foreign ? "not an SQLite file" : "damaged bag", what, kExpected);
}

Database open(const std::string& path) {
  std::error_code error;
  if (!std::filesystem::is_regular_file(path, error))
    throw InputError(path, 0, "", "unreadable file", "", "a file that is there");
  sqlite3* raw = nullptr;
  const int code = sqlite3_open_v2(path.c_str(), &raw, SQLITE_OPEN_READONLY, nullptr);
  Database db(raw);
  if (code != SQLITE_OK) refuse(path, raw, code);
  sqlite3_limit(raw, SQLITE_LIMIT_LENGTH, kMostBytes);
  sqlite3_db_config(raw, SQLITE_DBCONFIG_DEFENSIVE, 1, nullptr);
  sqlite3_db_config(raw, SQLITE_DBCONFIG_TRUSTED_SCHEMA, 0, nullptr);
  sqlite3_db_config(raw, SQLITE_DBCONFIG_ENABLE_VIEW, 0, nullptr);
  return db;
}

class Query {
 public:
  Query(const std::string& path, sqlite3* db, const char* sql) : path_(path), db_(db) {
    sqlite3_stmt* raw = nullptr;
    if (const int code = sqlite3_prepare_v2(db, sql, -1, &raw, nullptr); code != SQLITE_OK) {
      if (code != SQLITE_ERROR) refuse(path, db, code);
      throw InputError(path, 0, "", "not a bag", sqlite3_errmsg(db), kExpected);
    }
    statement_.reset(raw);
  }
  bool next() {
    const int code = sqlite3_step(statement_.get());
    if (code != SQLITE_ROW && code != SQLITE_DONE) refuse(path_, db_, code);
    return code == SQLITE_ROW;
  }
  /// Text or bytes of a column; valid until the next row.
  std::string_view bytes(int column) const {
    const void* data = sqlite3_column_blob(statement_.get(), column);
    const int size = sqlite3_column_bytes(statement_.get(), column);
    return data == nullptr
               ? std::string_view()
               : std::string_view(static_cast<const char*>(data), static_cast<std::size_t>(size));
  }
  std::string text(int column) const { return std::string(bytes(column)); }

 private:
  const std::string& path_;
  sqlite3* db_;
  Statement statement_;
};

/// A message that the recorder has packed; nothing: it is damaged.
std::optional<std::string> unpacked(std::string_view bytes) {
  const unsigned long long size = ZSTD_getFrameContentSize(bytes.data(), bytes.size());
  if (size > static_cast<unsigned long long>(kMostBytes)) return std::nullopt;  // or not known
  std::string out(size, '\0');
  const std::size_t got = ZSTD_decompress(out.data(), out.size(), bytes.data(), bytes.size());
  if (ZSTD_isError(got) || got != out.size()) return std::nullopt;
  return out;
}

bool is_packed(std::string_view bytes) { return bytes.starts_with("\x28\xB5\x2F\xFD"); }

}  // namespace

Recording read_db3(const std::string& path, std::size_t max_values) {
  const Database db = open(path);
  Recording recording;
  recording.file = path;
  RosRows rows(recording, max_values);
  Query messages(path, db.get(),
                 "SELECT t.name, t.type, t.serialization_format, m.data FROM messages m "
                 "JOIN topics t ON t.id = m.topic_id ORDER BY m.timestamp, m.id");
  while (messages.next()) {
    const std::string topic = messages.text(0), type = messages.text(1);
    if (!RosRows::reads(type)) continue;
    const std::string_view bytes = messages.bytes(3);
    if (!is_packed(bytes)) {
      rows.take(topic, type, messages.text(2), bytes);
      continue;
    }
    const std::optional<std::string> plain = unpacked(bytes);
    if (!plain) throw InputError(path, 0, topic, "damaged message", "zstd", "an intact file");
    rows.take(topic, type, messages.text(2), *plain);
  }
  rows.finish();
  return recording;
}

}  // namespace sanso::recording
