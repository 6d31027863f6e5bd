"""How the company of a teacher and its learner lies in memory: rows as in `sim.compiled.rows`, one lane a pair."""

APART, APART_ROUNDS, SEPARATIONS = range(3)
"""Whether the learner is separated, for how many rounds it has been, and how often it has become so."""
TEACHER_X, TEACHER_Y, TEACHER_DEGREES = 3, 4, 5
"""Where the teacher is, moved into the learner's arena: pixels and whole degrees."""
ROUNDS, VECTORS = 6, 7
"""Of the attempt under way: how many rounds, and how many experience vectors were recorded."""
COMPLETE, OVER = 8, 9
"""Whether the attempt is complete, and whether it has ended in any way."""
EPISODE, ATTEMPT = 10, 11
"""Numbers of the training episode that is under way, -1 when the lane has none left, and of the attempt at it."""
COMPANY_ROWS = 12

TEACHER, LEARNER = 0, 1
"""The two sides of a pair, each a world of its own."""
SIDES = 2

# Columns of the account of an attempt.
ACCOUNT_ROUNDS, ACCOUNT_VECTORS, ACCOUNT_SEPARATIONS, ACCOUNT_COMPLETE, ACCOUNT_COLUMNS = range(5)

# Columns of an experience vector: the state vector's five, and the behaviour heard.
HEARD = 5
VECTOR_COLUMNS = 6
