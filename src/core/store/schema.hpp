#pragma once

#include "database.hpp"

namespace sgraph {

/// Makes the tables of a new map file.
void make_schema(Database& database);

/// Refuses what is no map file, or one of a newer version: throws StoreError. Returns its schema's version.
int check_schema(Database& database);

/// Brings a file of an older schema to the present one, as a whole or not at all. Refuses what check_schema refuses.
void migrate_schema(Database& database);

}  // namespace sgraph
