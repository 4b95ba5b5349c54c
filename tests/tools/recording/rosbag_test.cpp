// Bags of ros2 (SQLite), written here with rosbag2's own table definitions: read as the same
// messages in MCAP are, and refused by name when they are damaged at any byte.
#include <gtest/gtest.h>
#include <sqlite3.h>
#include <unistd.h>
#include <zstd.h>

#include <cmath>
#include <filesystem>
#include <fstream>
#include <random>

#include "shared/files/input_error.h"
#include "shared/mcap/ros_messages.h"
#include "tests/support/write_mcap.h"
#include "tools/recording/mcap_recording.h"
#include "tools/recording/rosbag_db3.h"

namespace sanso::recording {
namespace {

using namespace sanso::mcap;

/// As rosbag2_storage_sqlite3 makes them (Humble).
constexpr char kTables[] =
    "CREATE TABLE schema(schema_version INTEGER PRIMARY KEY,ros_distro TEXT NOT NULL);"
    "CREATE TABLE metadata(id INTEGER PRIMARY KEY,metadata_version INTEGER NOT NULL,"
    "metadata TEXT NOT NULL);"
    "CREATE TABLE topics(id INTEGER PRIMARY KEY,name TEXT NOT NULL,type TEXT NOT NULL,"
    "serialization_format TEXT NOT NULL,offered_qos_profiles TEXT NOT NULL);"
    "CREATE TABLE messages(id INTEGER PRIMARY KEY,topic_id INTEGER NOT NULL,"
    "timestamp INTEGER NOT NULL, data BLOB NOT NULL);"
    "CREATE INDEX timestamp_idx ON messages (timestamp ASC);";

class Bag {
 public:
  explicit Bag(const std::string& path) {
    EXPECT_EQ(sqlite3_open(path.c_str(), &db_), SQLITE_OK);
    run(kTables);
  }
  ~Bag() { sqlite3_close(db_); }
  Bag(const Bag&) = delete;
  Bag& operator=(const Bag&) = delete;
  void run(const std::string& sql) {
    EXPECT_EQ(sqlite3_exec(db_, sql.c_str(), nullptr, nullptr, nullptr), SQLITE_OK)
        << sqlite3_errmsg(db_);
  }
  void topic(int id, const std::string& name, std::string_view type,
             const std::string& format = "cdr") {
    run("INSERT INTO topics VALUES(" + std::to_string(id) + ",'" + name + "','" +
        std::string(type) + "','" + format + "','')");
  }
  void message(int topic, double t, const std::string& data) {
    sqlite3_stmt* s = nullptr;
    sqlite3_prepare_v2(db_, "INSERT INTO messages(topic_id,timestamp,data) VALUES(?,?,?)", -1, &s,
                       nullptr);
    sqlite3_bind_int(s, 1, topic);
    sqlite3_bind_int64(s, 2, std::llround(1e9 * t));
    sqlite3_bind_blob(s, 3, data.data(), static_cast<int>(data.size()), SQLITE_TRANSIENT);
    EXPECT_EQ(sqlite3_step(s), SQLITE_DONE);
    sqlite3_finalize(s);
  }

 private:
  sqlite3* db_ = nullptr;
};

class Rosbag : public testing::Test {
 protected:
  void SetUp() override {
    folder_ = std::filesystem::temp_directory_path() / ("sanso_bag_" + std::to_string(::getpid()));
    std::filesystem::create_directories(folder_);
  }
  void TearDown() override { std::filesystem::remove_all(folder_); }
  std::string path(const char* name) const { return (folder_ / name).string(); }

  /// Which defect a file has; empty: none.
  static std::string defect_of(const std::string& file) {
    try {
      (void)read_recording(file);
      return {};
    } catch (const files::InputError& e) {
      EXPECT_EQ(e.file, file);
      EXPECT_FALSE(e.expected.empty());
      return e.defect;
    }
  }

  std::filesystem::path folder_;
};

Recording a_recording() {
  Recording r;
  std::vector<double> q, u, acc;
  for (int k = 0; k < 200; ++k) {
    const double t = 0.01 * k;
    r.t.push_back(t), q.push_back(std::sin(t)), u.push_back(std::sin(t + 0.1)), acc.push_back(9.8);
  }
  r.set("q:knee", q);
  r.set("u:knee", u);
  r.set("imu_acc:z", acc);
  return r;
}

/// The recording's messages, latest first: the order of a bag is that of its time stamps.
void write_bag(const Recording& r, const std::string& path, bool packed = false) {
  Bag bag(path);
  bag.topic(1, "/joint_states", kJointStateType);
  bag.topic(2, "/joint_commands", kJointStateType);
  bag.topic(3, "/imu", kImuType);
  bag.topic(4, "/chatter", "std_msgs/msg/String");
  const auto data = [&](std::string bytes) {
    if (!packed) return bytes;
    std::string out(ZSTD_compressBound(bytes.size()), '\0');
    out.resize(ZSTD_compress(out.data(), out.size(), bytes.data(), bytes.size(), 3));
    return out;
  };
  bag.run("BEGIN");
  for (std::size_t k = r.rows(); k-- > 0;) {
    const double t = r.t[k];
    Imu imu;
    imu.stamp_s = t;
    imu.linear_acceleration[2] = r.find("imu_acc:z")[k];
    bag.message(2, t, data(encode(JointState{t, {"knee"}, {r.find("u:knee")[k]}, {}, {}})));
    bag.message(3, t, data(encode(imu)));
    bag.message(4, t, data(std::string("\0\1\0\0\3\0\0\0hi\0", 11)));
    bag.message(1, t, data(encode(JointState{t, {"knee"}, {r.find("q:knee")[k]}, {}, {}})));
  }
  bag.run("COMMIT");
}

TEST_F(Rosbag, IsReadAsTheSameMessagesInMcap) {
  const Recording r = a_recording();
  write_mcap(r, path("a.mcap"));
  write_bag(r, path("a.db3"));
  write_bag(r, path("packed.db3"), true);
  const Recording mcap = read_recording(path("a.mcap"));
  for (const char* name : {"a.db3", "packed.db3"}) {
    const Recording bag = read_recording(path(name));
    ASSERT_EQ(bag.t, mcap.t) << name;
    for (const char* column : {"q:knee", "u:knee", "imu_acc:z"}) {
      ASSERT_TRUE(bag.has(column)) << column;
      for (std::size_t k = 0; k < bag.rows(); ++k)
        ASSERT_EQ(bag.find(column)[k], mcap.find(column)[k]) << column << k;
    }
  }
}

TEST_F(Rosbag, ASidecarBelongsToIt) {
  write_bag(a_recording(), path("b.db3"));
  std::ofstream(path("b.toml")) << "[recording]\ncondition = \"heavy\"\n";
  EXPECT_EQ(read_recording(path("b.db3")).condition, "heavy");
}

TEST_F(Rosbag, RefusesByName) {
  std::ofstream(path("text.db3")) << "t,q:knee\n0,0\n and so on, for longer than a header is\n";
  EXPECT_EQ(defect_of(path("text.db3")), "not an SQLite file");
  EXPECT_EQ(defect_of(path("none.db3")), "unreadable file");
  std::ofstream(path("empty.db3")) << "";
  EXPECT_EQ(defect_of(path("empty.db3")), "not a bag");
  {
    Bag bag(path("silent.db3"));
    bag.topic(1, "/chatter", "std_msgs/msg/String");
  }
  EXPECT_EQ(defect_of(path("silent.db3")), "no joint states");
  {
    Bag bag(path("json.db3"));
    bag.topic(1, "/joint_states", kJointStateType, "json");
    bag.message(1, 0, "{}");
  }
  EXPECT_EQ(defect_of(path("json.db3")), "unknown message encoding");
  for (const std::string& bytes :
       {std::string("\x28\xB5\x2F\xFDnonsense"), std::string("\0\1", 2)}) {
    std::filesystem::remove(path("bad.db3"));
    {
      Bag bag(path("bad.db3"));
      bag.topic(1, "/joint_states", kJointStateType);
      bag.message(1, 0, bytes);
    }
    EXPECT_EQ(defect_of(path("bad.db3")), "damaged message");
  }
}

/// A file can be a view that never ends, in the place of a table.
TEST_F(Rosbag, NothingOfTheFileIsExecuted) {
  {
    Bag bag(path("view.db3"));
    bag.topic(1, "/joint_states", kJointStateType);
    bag.run(
        "DROP TABLE messages; CREATE VIEW messages AS WITH RECURSIVE n(id) AS (SELECT 1 UNION ALL "
        "SELECT id+1 FROM n) SELECT id, 1 AS topic_id, id AS timestamp, x'00' AS data FROM n;");
  }
  EXPECT_EQ(defect_of(path("view.db3")), "not a bag");
}

/// Cut anywhere, or with bytes of chance: rows that could have been recorded, or an error that
/// names the file.
TEST_F(Rosbag, DamagedFilesAreErrors) {
  write_bag(a_recording(), path("whole.db3"));
  std::ifstream in(path("whole.db3"), std::ios::binary);
  const std::string whole((std::istreambuf_iterator<char>(in)), std::istreambuf_iterator<char>());
  std::mt19937 random(7);
  int refused = 0;
  for (int trial = 0; trial < 300; ++trial) {
    std::string bytes = whole;
    if (trial % 3 == 0) bytes.resize(random() % bytes.size());
    for (int k = 0; !bytes.empty() && k < trial % 40; ++k)
      bytes[random() % bytes.size()] = static_cast<char>(random());
    std::ofstream(path("damaged.db3"), std::ios::binary) << bytes;
    refused += defect_of(path("damaged.db3")).empty() ? 0 : 1;
  }
  EXPECT_GT(refused, 100);
}

}  // namespace
}  // namespace sanso::recording
