"""Request: one identification as a command line, or a row of a table, says it, as
values of the library.

What is said is an object with an attribute for each option of ``hefting identify``, its
name with underscores, such as the parsed arguments of a command. Texts are as they are
typed; None is what was not given. Errors name the option.
"""
