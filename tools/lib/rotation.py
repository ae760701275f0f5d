"""Rotations, for tools that are written in Python."""


def quaternion(m):
    """x y z w of a rotation, by the largest of the four."""
    q = [m[0][0] - m[1][1] - m[2][2], m[1][1] - m[0][0] - m[2][2], m[2][2] - m[0][0] - m[1][1],
         m[0][0] + m[1][1] + m[2][2]]
    i = q.index(max(q))
    big = (q[i] + 1) ** 0.5 / 2
    part = 1 / (4 * big)
    if i == 3:
        return [(m[2][1] - m[1][2]) * part, (m[0][2] - m[2][0]) * part,
                (m[1][0] - m[0][1]) * part, big]
    j, k = (i + 1) % 3, (i + 2) % 3
    out = [0.0] * 4
    out[i], out[j], out[k] = big, (m[i][j] + m[j][i]) * part, (m[i][k] + m[k][i]) * part
    out[3] = (m[k][j] - m[j][k]) * part
    return out
