"""Request: the options of one identification, from a command line or a row of a table,
and the library's values for them.

A request is an object with an attribute for each option of ``hefting identify``, its
name with underscores, such as the parsed arguments of a command. Texts are as typed;
options that were not given are None. Errors name the option.
"""
