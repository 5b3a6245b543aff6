// SPDX-License-Identifier: Apache-2.0
// The mesh's cell at a place of the still sea. Needs the binding Rows.

struct MeshCell {
    vec2 at;     ///< row and column, with the place within the cell as their fractions
    vec2 along;  ///< from row to row, m of the still sea
    vec2 across; ///< from column to column
};

MeshCell mesh_cell(vec2 undisplaced_m) {
    const vec2 from_apex = undisplaced_m - view.mesh_apex_m;
    const float r = length(from_apex);
    int low = 0;
    int high = view.mesh_rows - 1;
    while (high - low > 1) {
        const int middle = (low + high) / 2;
        if (row_distance_m[middle] <= r)
            low = middle;
        else
            high = middle;
    }
    const float turn = atan(from_apex.y, from_apex.x) - view.mesh_azimuth_rad;
    const float two_pi = 6.2831853;
    const float column = (turn - two_pi * floor(turn / two_pi)) / view.mesh_step_rad;
    const float length_m = row_distance_m[high] - row_distance_m[low];
    const vec2 outwards = from_apex / max(r, 1e-6);
    return MeshCell(vec2(float(low) + (r - row_distance_m[low]) / length_m, column), length_m * outwards,
                    r * view.mesh_step_rad * vec2(-outwards.y, outwards.x));
}
