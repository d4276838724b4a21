#include "schema.hpp"

#include "sgraph_slam/core/store/map_store.hpp"

namespace sgraph {
namespace {

constexpr int application_id = 0x53474d50;  // "SGMP"

// Measurements are written once; estimates (poses, planes) are apart from them, so that a solve does not write clouds again. Poses are seven doubles
// x y z qx qy qz qw, matrices row by row, outlines three doubles a corner.
constexpr const char* tables = R"(
CREATE TABLE sessions(id INTEGER PRIMARY KEY, source TEXT, sensor TEXT, started INTEGER, base_lidar BLOB, frame TEXT, parameters TEXT, program TEXT,
                      localisation TEXT);
CREATE TABLE keyframes(id INTEGER PRIMARY KEY, session INTEGER NOT NULL, stamp INTEGER NOT NULL, odometry BLOB NOT NULL, covariance BLOB NOT NULL,
                       degenerate BLOB NOT NULL, scans BLOB NOT NULL);
CREATE TABLE poses(keyframe INTEGER PRIMARY KEY, pose BLOB NOT NULL);
CREATE TABLE clouds(keyframe INTEGER PRIMARY KEY, points INTEGER NOT NULL, data BLOB NOT NULL);
CREATE TABLE planes(id INTEGER PRIMARY KEY, class TEXT NOT NULL, plane BLOB NOT NULL, covariance BLOB NOT NULL, view_covariance BLOB NOT NULL,
                    extent BLOB NOT NULL);
CREATE TABLE views(factor INTEGER PRIMARY KEY, keyframe INTEGER NOT NULL, extent BLOB NOT NULL);
CREATE TABLE factors(id INTEGER PRIMARY KEY, value TEXT NOT NULL);
CREATE TABLE merges(merged INTEGER PRIMARY KEY, value TEXT NOT NULL);
CREATE TABLE decisions(number INTEGER PRIMARY KEY, keyframe INTEGER NOT NULL, accepted INTEGER NOT NULL, what TEXT NOT NULL, reason TEXT NOT NULL);
CREATE TABLE documents(name TEXT PRIMARY KEY, value TEXT NOT NULL) WITHOUT ROWID;
)";

// Schema 2. Until then a plane of a file was of the keyframes only that keep views of it. Which others saw it, such a file does not tell.
constexpr const char* sightings_table =
    "CREATE TABLE sightings(plane INTEGER NOT NULL, keyframe INTEGER NOT NULL, PRIMARY KEY(plane, keyframe)) WITHOUT ROWID";

void set_version(Database& database) { database.execute("PRAGMA user_version = " + std::to_string(store_schema)); }

}  // namespace

void make_schema(Database& database) {
  DatabaseTransaction transaction(database);
  database.execute("PRAGMA application_id = " + std::to_string(application_id));
  database.execute(tables);
  database.execute(sightings_table);
  set_version(database);
  transaction.commit();
}

void migrate_schema(Database& database) {
  if (check_schema(database) == store_schema) return;
  DatabaseTransaction transaction(database);
  // Another program may have done it since; within the transaction nobody else can.
  if (check_schema(database) < 2) database.execute(sightings_table);
  set_version(database);
  transaction.commit();
}

int check_schema(Database& database) {
  if (database.number("PRAGMA application_id") != application_id) throw StoreError(database.path() + ": it is no map file");
  const auto version = static_cast<int>(database.number("PRAGMA user_version"));
  if (version > store_schema) {
    throw StoreError(database.path() + ": it was written by a newer version of this program (schema " + std::to_string(version) +
                     "; this one reads up to " + std::to_string(store_schema) + ")");
  }
  if (version < 1) throw StoreError(database.path() + ": it is no map file");
  return version;
}

}  // namespace sgraph
